#include "core/render/pixel_estimate.h"

#include <algorithm>

namespace qray {
namespace {

constexpr int kRadiusPx = 4;

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

void PixelEstimate::update(const Film& film) {
  if (film.version() == 0) return;
  const Image image = film.develop();
  width_ = image.width();
  const size_t width = static_cast<size_t>(width_), height = static_cast<size_t>(image.height());
  luminance_.resize(width * height);
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < width_; ++x)
      luminance_[static_cast<size_t>(y) * width + static_cast<size_t>(x)] =
          luminance(image.rgb(x, y));
  std::vector<double> sums;
  for (size_t y = 0; y < height; ++y) blur_line(&luminance_[y * width], width_, 1, sums);
  for (size_t x = 0; x < width; ++x) blur_line(&luminance_[x], image.height(), width, sums);
}

}  // namespace qray
