#include "core/recover/upsample.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/check.h"
#include "core/recover/network.h"

namespace qray {
namespace {

// Of feature_distances(), and the least weight: some tap always counts.
constexpr std::array<float, kDistances> kScales{17, 3750, 1.5f, 150};
constexpr float kLeastWeight = 1e-6f;

}  // namespace

Image upsampled(const Image& colour, const Image& features, TaskPool& pool) {
  QRAY_CHECK(features.width() == 2 * colour.width() && features.height() == 2 * colour.height());
  Image out = Image::unset(features.width(), features.height(), 3);
  const auto at = [&](int x, int y) {
    return &features.data()[(static_cast<size_t>(y) * static_cast<size_t>(features.width()) +
                             static_cast<size_t>(x)) *
                            kFeatures];
  };
  pool.run(static_cast<size_t>(out.height()), [&](size_t row, int) {
    const int y = static_cast<int>(row);
    const int last_y = std::min(y / 2 + y % 2, colour.height() - 1);
    for (int x = 0; x < out.width(); ++x) {
      const int last_x = std::min(x / 2 + x % 2, colour.width() - 1);
      const float* pixel = at(x, y);
      Rgb sum;
      float weights = 0;
      for (int by = y / 2; by <= last_y; ++by)
        for (int bx = x / 2; bx <= last_x; ++bx) {
          const float* tap = at(2 * bx, 2 * by);
          const std::array<float, kDistances> distances = feature_distances(pixel, tap);
          float distance = 0;
          for (size_t d = 0; d < kDistances; ++d) distance += kScales[d] * distances[d];
          const float weight = std::exp(-distance) + kLeastWeight;
          weights += weight;
          const Rgb c = colour.rgb(bx, by);
          for (int k = 0; k < 3; ++k) sum[k] += weight * c[k] / (tap[k] + kAlbedoFloor);
        }
      for (int k = 0; k < 3; ++k) sum[k] *= (pixel[k] + kAlbedoFloor) / weights;
      out.set_rgb(x, y, sum);
    }
  });
  return out;
}

}  // namespace qray
