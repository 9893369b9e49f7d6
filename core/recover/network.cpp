#include "core/recover/network.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/math/hash.h"

namespace qray {
namespace {

constexpr float kFirstFalloff = 0.6f;   // of the logits of up taps, by squared distance in blocks
constexpr float kFirstKnownLogit = -2;  // of the block's known pixel

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

Network::Parts Network::parts() const {
  const size_t h = static_cast<size_t>(hidden);
  Parts p{};
  p.bias1 = p.weights1 + kInputs * h;
  p.weights2 = p.bias1 + h;
  p.bias2 = p.weights2 + kTaps * h * h;
  p.weights3 = p.bias2 + h;
  p.bias3 = p.weights3 + h * kLogits;
  p.scales = p.bias3 + kLogits;
  p.size = p.scales + static_cast<size_t>(kDistances) * (kFilters + 1);
  return p;
}

Network untrained_network(int hidden, uint64_t seed) {
  QRAY_CHECK(hidden > 0 && hidden % 16 == 0);
  Network net{hidden, {}};
  const Network::Parts parts = net.parts();
  net.values.assign(parts.size, 0);
  const std::span<float> values = net.values;
  fill_at_random(values.subspan(parts.weights1, parts.bias1 - parts.weights1), kInputs, seed);
  fill_at_random(values.subspan(parts.weights2, parts.bias2 - parts.weights2), kTaps * hidden,
                 seed);
  float* bias = &net.values[parts.bias3 + kUpLogits];
  for (int s = 0; s < kBlock; ++s, bias += kUpTaps) {
    const float sy = static_cast<float>(s / 2) / 2, sx = static_cast<float>(s % 2) / 2;
    for (int t = 0; t < kTaps; ++t)
      bias[t] = -kFirstFalloff * (squared(static_cast<float>(t / 3 - 1) - sy) +
                                  squared(static_cast<float>(t % 3 - 1) - sx));
    bias[kTaps] = kFirstKnownLogit;
  }
  for (int f = 0; f <= kFilters; ++f)
    for (int d = 0; d < kDistances; ++d)
      net.values[parts.scales + static_cast<size_t>(f * kDistances + d)] =
          std::log(kFirstScales[static_cast<size_t>(d)]);
  return net;
}

}  // namespace qray
