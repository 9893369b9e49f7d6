#include "core/chart/error_map.h"

#include <cmath>

#include "core/base/check.h"
#include "core/image/false_color.h"

namespace qray {

Image error_map(const Image& picture, const Image& reference) {
  QRAY_CHECK(picture.width() == reference.width() && picture.height() == reference.height());
  Image map(picture.width(), picture.height(), 3);
  for (int y = 0; y < map.height(); ++y)
    for (int x = 0; x < map.width(); ++x) {
      float error = 0;
      for (int c = 0; c < 3; ++c) {
        const float r = reference.at(x, y, c), difference = picture.at(x, y, c) - r;
        error += difference * difference / (r * r + 0.01f) / 3;
      }
      map.set_rgb(x, y, viridis(log_scale(error, kErrorMapLow, kErrorMapHigh)));
    }
  return map;
}

}  // namespace qray
