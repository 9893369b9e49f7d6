// The recovery network of what is sampled in blocks: from the known pixels of a picture and the
// features of all of them to the whole picture. It works on blocks of 2 x 2 pixels, of which pixel
// 0 (top left) is known:
//
//   input    colour / (albedo + kAlbedoFloor), as x / (1 + x); its noise; the 4 pixels' features
//   layers   1x1 to `hidden`, leaky; 3x3 to `hidden`, leaky; 1x1 to kLogits
//   kernels  four a-trous filters of 9 taps over known pixels (1, 2, 4, 8 blocks apart), then for
//            each of the 4 pixels 9 taps of what they made and 1 of the block's own known pixel
//
// Each kernel is a softmax of its logits, less the distances of the taps' features from the
// pixel's, in learned scales: a convex combination, which invents nothing. With zero weights in the
// layers it is a joint bilateral filter. Plain data; any thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace qray {

// Of a pixel, in this order: albedo (3), normal (3), depth along the ray, kind of material.
constexpr int kFeatures = 8;
constexpr int kFeatureNormal = 3, kFeatureDepth = 6, kFeatureKind = 7;
constexpr float kAlbedoFloor = 0.01f;

constexpr int kBlock = 4;  // pixels of a block, row by row
constexpr int kColour = 3;
constexpr int kInputNoise = kColour, kInputFeatures = kInputNoise + 1;
constexpr int kInputs = kInputFeatures + kBlock * kFeatures;

constexpr int kTaps = 9;  // row by row, the middle one fifth
constexpr std::array<int, 4> kDilations{1, 2, 4, 8};
constexpr int kFilters = static_cast<int>(kDilations.size());
constexpr int kUpTaps = kTaps + 1;           // the last: the block's known pixel
constexpr int kUpLogits = kFilters * kTaps;  // where those of pixel 0 begin
constexpr int kUsedLogits = kUpLogits + kBlock * kUpTaps;
constexpr int kLogits = (kUsedLogits + 15) / 16 * 16;  // with padding
constexpr float kSlope = 0.1f;                         // of the leaky units
constexpr float kMaxDepthDistance = 0.02f;

// What a tap's features differ by: squared differences of normals, depths (relative), albedos and
// kinds.
constexpr int kDistances = 4;
std::array<float, kDistances> feature_distances(const float* pixel, const float* tap);

struct Network {
  int hidden = 16;            // a multiple of 16
  std::vector<float> values;  // by the offsets below
  // Cleans samples (pyramid.h); none: the network for blocks does it, for all pixels four times.
  std::vector<float> pyramid{};

  // Where each part begins in `values`. Weights lie [tap][input][output].
  struct Parts {
    size_t weights1, bias1, weights2, bias2, weights3, bias3;
    size_t scales;  // logarithms, kDistances for each filter and then for the four pixels alike
    size_t size;
  };
  Parts parts() const;
};

// What the scales of distances begin with.
constexpr std::array<float, kDistances> kFirstScales{5.6f, 1250, 0.5f, 50};

// Weights of a layer with so many inputs to a unit, as He et al. begin ("Delving Deep into
// Rectifiers", 2015): of variance 2 over the inputs. Moves the seed on.
void fill_at_random(std::span<float> weights, int inputs, uint64_t& seed);

// The joint bilateral filter that an untrained network is: no weight in the last layer.
Network untrained_network(int hidden, uint64_t seed);

}  // namespace qray
