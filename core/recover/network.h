// What recovery sees of a pixel, and the values of the network that it is made by. Plain data; any
// thread.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace qray {

// Of a pixel, in this order: albedo (3), normal (3), depth along the ray, kind of material.
constexpr int kFeatures = 8;
constexpr int kFeatureNormal = 3, kFeatureDepth = 6, kFeatureKind = 7;
// Colours are cleaned over albedo and this, so that textures stay sharp.
constexpr float kAlbedoFloor = 0.01f;
constexpr int kColour = 3;

// What a tap's features differ by: squared differences of normals, depths (relative), albedos and
// kinds.
constexpr int kDistances = 4;
constexpr float kMaxDepthDistance = 0.02f;
std::array<float, kDistances> feature_distances(const float* pixel, const float* tap);
// What the scales of distances begin with.
constexpr std::array<float, kDistances> kFirstScales{5.6f, 1250, 0.5f, 50};

// pyramid.h says what stands where.
struct Network {
  std::vector<float> values;  // pyramid_size() of them, or none: nothing is cleaned
  bool empty() const { return values.empty(); }
};

// Weights of a layer with so many inputs to a unit, as He et al. begin ("Delving Deep into
// Rectifiers", 2015): of variance 2 over the inputs. Moves the seed on.
void fill_at_random(std::span<float> weights, int inputs, uint64_t& seed);

}  // namespace qray
