#include "core/recover/network.h"

#include <algorithm>
#include <cmath>

#include "core/math/hash.h"

namespace qray {
namespace {

float squared(float v) { return v * v; }

// Uniform in (-1, 1), of variance 1/3.
float symmetric(uint64_t& state) {
  state = mix64(state + 0x9e3779b97f4a7c15u);
  return static_cast<float>(static_cast<double>(state >> 11) * 0x1p-52 - 1);
}

}  // namespace

void fill_at_random(std::span<float> weights, int inputs, uint64_t& seed) {
  const float width = std::sqrt(6.0f / static_cast<float>(inputs));
  for (float& w : weights) w = width * symmetric(seed);
}

std::array<float, kDistances> feature_distances(const float* pixel, const float* tap) {
  float normal = 0, albedo = 0;
  for (int k = 0; k < 3; ++k) {
    normal += squared(pixel[kFeatureNormal + k] - tap[kFeatureNormal + k]);
    albedo += squared(pixel[k] - tap[k]);
  }
  const float depth = (pixel[kFeatureDepth] - tap[kFeatureDepth]) / (pixel[kFeatureDepth] + 0.01f);
  return {normal, std::min(squared(depth), kMaxDepthDistance), albedo,
          squared(pixel[kFeatureKind] - tap[kFeatureKind])};
}

}  // namespace qray
