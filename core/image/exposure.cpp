#include "core/image/exposure.h"

#include <algorithm>
#include <cmath>

namespace qray {

void expose(Image& image, float stops) {
  const float scale = std::exp2(stops);
  if (scale == 1) return;
  for (float& v : image.data()) v *= scale;
}

float auto_exposure(const Image& image) {
  double sum = 0;
  int64_t count = 0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const float v = luminance(image.rgb(x, y));
      if (!(v > 0) || !std::isfinite(v)) continue;
      sum += std::log2(static_cast<double>(v));
      ++count;
    }
  }
  if (count == 0) return 0;
  const double stops = std::log2(0.18) - sum / static_cast<double>(count);
  return std::clamp(static_cast<float>(stops), -kMaxExposure, kMaxExposure);
}

}  // namespace qray
