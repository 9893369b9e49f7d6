// Shared-exponent colour in 32 bits: OpenGL's GL_RGB9_E5 (EXT_texture_shared_exponent, section
// 3.8.x), three 9-bit mantissas and a 5-bit exponent, bias 15. Largest value 65408; negatives and
// NaN become 0.
#pragma once

#include <bit>
#include <cstdint>

#include "core/math/vec.h"

namespace qray {

inline uint32_t pack_rgb9e5(Rgb c) {
  static constexpr float kMax = 65408.0f;
  const auto clean = [](float v) { return v > 0 ? std::min(v, kMax) : 0.0f; };
  const float r = clean(c.r), g = clean(c.g), b = clean(c.b);
  const float top = std::max(r, std::max(g, b));
  if (top < 0x1p-25f) return 0;
  const int log2_top = static_cast<int>(std::bit_cast<uint32_t>(top) >> 23) - 127;  // floor
  int exponent = std::max(-16, log2_top) + 16;
  float scale = std::bit_cast<float>(static_cast<uint32_t>(127 + 24 - exponent) << 23);
  if (static_cast<int>(top * scale + 0.5f) == 512) {
    ++exponent;
    scale *= 0.5f;
  }
  const auto mantissa = [&](float v) { return static_cast<uint32_t>(v * scale + 0.5f); };
  return mantissa(r) | mantissa(g) << 9 | mantissa(b) << 18 | static_cast<uint32_t>(exponent) << 27;
}

// pack_rgb9e5() as four bytes, little-endian.
inline void put_rgb9e5(Rgb color, uint8_t* to) {
  const uint32_t packed = pack_rgb9e5(color);
  for (int k = 0; k < 4; ++k) to[k] = static_cast<uint8_t>(packed >> (8 * k));
}

inline Rgb unpack_rgb9e5(uint32_t v) {
  const float scale = std::ldexp(1.0f, static_cast<int>(v >> 27) - 24);
  return Rgb{static_cast<float>(v & 511), static_cast<float>(v >> 9 & 511),
             static_cast<float>(v >> 18 & 511)} *
         scale;
}

}  // namespace qray
