#include "core/render/pixel_estimate.h"

#include <algorithm>
#include <cmath>

namespace qray {
namespace {

constexpr int kRadiusPx = 4;
constexpr float kKeep = 0.5f;          // of earlier passes, each pass: the guide gets better
constexpr float kDeviation = 1.2533f;  // over the mean absolute distance (of a normal variable),
                                       // which outliers move less than the mean square

// Means over 2 kRadiusPx + 1 values along a line, fewer at its ends.
void blur_line(float* values, int count, size_t stride, std::vector<double>& sums) {
  sums.assign(static_cast<size_t>(count) + 1, 0);
  for (int i = 0; i < count; ++i)
    sums[static_cast<size_t>(i) + 1] =
        sums[static_cast<size_t>(i)] + static_cast<double>(values[static_cast<size_t>(i) * stride]);
  for (int i = 0; i < count; ++i) {
    const int lo = std::max(0, i - kRadiusPx), hi = std::min(count, i + kRadiusPx + 1);
    values[static_cast<size_t>(i) * stride] = static_cast<float>(
        (sums[static_cast<size_t>(hi)] - sums[static_cast<size_t>(lo)]) / (hi - lo));
  }
}

}  // namespace

void PixelEstimate::update(const Film& film, uint64_t samples) {
  if (samples <= samples_) return;
  const Image image = film.develop();
  width_ = image.width();
  const size_t width = static_cast<size_t>(width_), height = static_cast<size_t>(image.height());
  const float before = static_cast<float>(samples_), all = static_cast<float>(samples);
  const float pass = all - before;
  const bool first = samples_ == 0, second = distance_.empty();
  mean_.resize(width * height);
  if (!first) distance_.resize(width * height);
  for (size_t i = 0; i < mean_.size(); ++i) {
    const int x = static_cast<int>(i % width), y = static_cast<int>(i / width);
    const float mean = luminance(image.rgb(x, y));
    if (!first) {
      // The pass and what was before are independent: variance (1 / pass + 1 / before).
      const float of_pass = (mean * all - mean_[i] * before) / pass;
      const float distance = std::abs(of_pass - mean_[i]) / std::sqrt(1 / pass + 1 / before);
      distance_[i] = second ? distance : lerp(kKeep, distance, distance_[i]);
    }
    mean_[i] = mean;
  }
  samples_ = samples;
  if (first) return;
  deviation_ = distance_;
  for (float& d : deviation_) d *= kDeviation;
  std::vector<double> sums;
  for (size_t y = 0; y < height; ++y) blur_line(&deviation_[y * width], width_, 1, sums);
  for (size_t x = 0; x < width; ++x) blur_line(&deviation_[x], image.height(), width, sums);
}

}  // namespace qray
