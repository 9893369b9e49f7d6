#include "core/image/false_color.h"

#include <cmath>
#include <cstdint>

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
  const float x = t > 0 ? std::min(t, 1.0f) * kViridisSteps : 0;
  const int step = std::min(static_cast<int>(x), kViridisSteps - 1);
  const float in_step = x - static_cast<float>(step);
  return srgb_to_linear(from_hex(kViridis[step]) * (1 - in_step) +
                        from_hex(kViridis[step + 1]) * in_step);
}

Rgb diverging(float t) {
  constexpr uint32_t kBlue = 0x3b4cc0, kWhite = 0xdddddd, kRed = 0xb40426;
  const float part = std::min(std::abs(t) > 0 ? std::abs(t) : 0.0f, 1.0f);
  return srgb_to_linear(from_hex(kWhite) * (1 - part) + from_hex(t > 0 ? kRed : kBlue) * part);
}

}  // namespace qray
