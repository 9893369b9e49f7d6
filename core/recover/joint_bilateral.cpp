#include "core/recover/joint_bilateral.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/check.h"
#include "core/image/metrics.h"

namespace qray {
namespace {

constexpr int kMostRadius = 6;  // blocks
constexpr int kRounds = 3;      // over all widths

void filter_row(const JointBilateral& filter, const Image& features, const Image& input, int y,
                Image& out) {
  const int blocks_x = input.width() / 2, blocks_y = input.height() / 2;
  const int radius = std::clamp(static_cast<int>(std::ceil(2 * filter.sigma)), 1, kMostRadius);
  const float falloff = 1 / (2 * filter.sigma * filter.sigma);
  const auto at = [&](int px, int py) {
    return &features.data()[(static_cast<size_t>(py) * static_cast<size_t>(features.width()) +
                             static_cast<size_t>(px)) *
                            kFeatures];
  };
  for (int x = 0; x < input.width(); ++x) {
    const float* pixel = at(x, y);
    Rgb sum;
    float weights = 0;
    for (int by = std::max(0, y / 2 - radius); by <= std::min(blocks_y - 1, y / 2 + radius); ++by)
      for (int bx = std::max(0, x / 2 - radius); bx <= std::min(blocks_x - 1, x / 2 + radius);
           ++bx) {
        const float dx = 0.5f * static_cast<float>(x) - static_cast<float>(bx),
                    dy = 0.5f * static_cast<float>(y) - static_cast<float>(by);
        const float* tap = at(2 * bx, 2 * by);
        const std::array<float, kDistances> distances = feature_distances(pixel, tap);
        float distance = falloff * (dx * dx + dy * dy);
        for (size_t d = 0; d < kDistances; ++d) distance += filter.scales[d] * distances[d];
        const float weight = std::exp(-distance) + 1e-12f;  // never none at all
        weights += weight;
        const Rgb colour = input.rgb(2 * bx, 2 * by);
        for (int c = 0; c < 3; ++c) sum[c] += weight * colour[c] / (tap[c] + kAlbedoFloor);
      }
    for (int c = 0; c < 3; ++c) out.at(x, y, c) = sum[c] / weights * (pixel[c] + kAlbedoFloor);
  }
}

}  // namespace

Image joint_bilateral(const JointBilateral& filter, const Image& features, const Image& input,
                      TaskPool& pool) {
  QRAY_CHECK(input.width() % 2 == 0 && input.height() % 2 == 0);
  Image out(input.width(), input.height(), 3);
  pool.run(static_cast<size_t>(input.height()),
           [&](size_t y, int) { filter_row(filter, features, input, static_cast<int>(y), out); });
  return out;
}

JointBilateral fitted_joint_bilateral(std::span<const TrainingView> views, TaskPool& pool) {
  const auto error_of = [&](const JointBilateral& filter) {
    double sum = 0;
    for (const TrainingView& view : views)
      sum += relmse(joint_bilateral(filter, view.input.features, view.input.colour, pool),
                    view.target);
    return sum;
  };
  JointBilateral best;
  double least = error_of(best);
  for (int round = 0; round < kRounds; ++round) {
    const double before = least;
    for (int k = 0; k <= kDistances; ++k)
      for (float factor : {0.5f, 2.0f})
        for (JointBilateral next = best;;) {
          (k == 0 ? next.sigma : next.scales[static_cast<size_t>(k - 1)]) *= factor;
          const double error = error_of(next);
          if (!(error < least)) break;
          least = error;
          best = next;
        }
    if (!(least < before)) break;
  }
  return best;
}

}  // namespace qray
