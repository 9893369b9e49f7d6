#include "core/chart/error_map.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/base/check.h"
#include "core/image/tonemap.h"

namespace qray {
namespace {

// Nine equal steps of the published table, sRGB.
constexpr int kViridisSteps = 8;
constexpr uint32_t kViridis[kViridisSteps + 1] = {0x440154, 0x472d7b, 0x3b528b, 0x2c728e, 0x21918c,
                                                  0x28ae80, 0x5ec962, 0xaddc30, 0xfde725};

Rgb from_hex(uint32_t hex) {
  return Rgb{static_cast<float>(hex >> 16 & 255), static_cast<float>(hex >> 8 & 255),
             static_cast<float>(hex & 255)} *
         (1 / 255.0f);
}

}  // namespace

Rgb viridis(float t) {
  const float x = std::clamp(t, 0.0f, 1.0f) * kViridisSteps;
  const int step = std::min(static_cast<int>(x), kViridisSteps - 1);
  const float in_step = x - static_cast<float>(step);
  return srgb_to_linear(from_hex(kViridis[step]) * (1 - in_step) +
                        from_hex(kViridis[step + 1]) * in_step);
}

Image error_map(const Image& picture, const Image& reference) {
  QRAY_CHECK(picture.width() == reference.width() && picture.height() == reference.height());
  Image map(picture.width(), picture.height(), 3);
  const float decades = std::log10(kErrorMapHigh / kErrorMapLow);
  for (int y = 0; y < map.height(); ++y)
    for (int x = 0; x < map.width(); ++x) {
      float error = 0;
      for (int c = 0; c < 3; ++c) {
        const float r = reference.at(x, y, c), difference = picture.at(x, y, c) - r;
        error += difference * difference / (r * r + 0.01f) / 3;
      }
      map.set_rgb(x, y, viridis(error > 0 ? std::log10(error / kErrorMapLow) / decades : 0));
    }
  return map;
}

}  // namespace qray
