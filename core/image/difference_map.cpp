#include "core/image/difference_map.h"

#include <cmath>

#include "core/base/check.h"
#include "core/image/false_color.h"
#include "core/image/flip.h"

namespace qray {
namespace {

double mean_luminance(const Image& image) {
  double sum = 0;
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) sum += static_cast<double>(luminance(image.rgb(x, y)));
  return sum / (static_cast<double>(image.width()) * image.height());
}

template <class ColorAt>
Image map_of(const Image& picture, const Image& other, const ColorAt& color_at) {
  QRAY_CHECK(picture.width() == other.width() && picture.height() == other.height());
  Image map(picture.width(), picture.height(), 3);
  for (int y = 0; y < map.height(); ++y)
    for (int x = 0; x < map.width(); ++x) map.set_rgb(x, y, color_at(x, y));
  return map;
}

}  // namespace

Image error_map(const Image& picture, const Image& reference) {
  return map_of(picture, reference, [&](int x, int y) {
    float error = 0;
    for (int c = 0; c < 3; ++c) {
      const float r = reference.at(x, y, c), difference = picture.at(x, y, c) - r;
      error += difference * difference / (r * r + 0.01f) / 3;
    }
    return viridis(log_scale(error, kErrorMapLow, kErrorMapHigh));
  });
}

Image signed_map(const Image& picture, const Image& other) {
  const double mean = (mean_luminance(picture) + mean_luminance(other)) / 2;
  const float scale = mean > 0 ? static_cast<float>(1 / mean) : 0.0f;
  return map_of(picture, other, [&](int x, int y) {
    const float difference = luminance(picture.rgb(x, y)) - luminance(other.rgb(x, y));
    return diverging(difference * scale / kSignedMapMost);
  });
}

Image flip_false_color(const Image& picture, const Image& reference) {
  const Image flip = flip_map(picture, reference);
  return map_of(picture, reference, [&](int x, int y) { return viridis(flip.at(x, y, 0)); });
}

}  // namespace qray
