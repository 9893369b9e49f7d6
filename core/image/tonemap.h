// Linear light to display values and back: the sRGB transfer curve (IEC 61966-2-1). Any thread.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/math/vec.h"

namespace qray {

// Clamps to [0, 1]; NaN becomes 0.
inline float linear_to_srgb(float v) {
  v = v > 0 ? std::min(v, 1.0f) : 0.0f;
  return v <= 0.0031308f ? 12.92f * v : 1.055f * std::pow(v, 1 / 2.4f) - 0.055f;
}
inline float srgb_to_linear(float v) {
  return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
}
inline Rgb srgb_to_linear(Rgb c) {
  return {srgb_to_linear(c.r), srgb_to_linear(c.g), srgb_to_linear(c.b)};
}

}  // namespace qray
