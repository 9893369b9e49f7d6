// Maps from the unit square to directions and shapes, with their densities (pbrt-v4, appendix A.5).
// Directions are local, +z up; pdf_w is per steradian.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "core/math/vec.h"

namespace qray {

// sin and cos of x in [-pi/4, pi/4], within 1e-7: the first terms of their Taylor series.
struct SinCos {
  float sin, cos;
};
constexpr SinCos sin_cos_quarter(float x) {
  const float x2 = x * x;
  return {x * (1 + x2 * (-1 / 6.0f + x2 * (1 / 120.0f + x2 * (-1 / 5040.0f + x2 / 362880)))),
          1 + x2 * (-1 / 2.0f + x2 * (1 / 24.0f + x2 * (-1 / 720.0f + x2 / 40320)))};
}

// The angle of (x, y) from the x axis, in [-pi, pi], within 3e-7: a polynomial (Abramowitz and
// Stegun 1964, 4.4.49) takes a third of the library's time. (0, 0): 0.
inline float angle_of(float y, float x) {
  const float ax = std::abs(x), ay = std::abs(y), longer = std::max(ax, ay);
  const float t = longer > 0 ? std::min(ax, ay) / longer : 0, t2 = t * t;
  float tail = 0.0028662257f;
  for (const float c : {-0.0161657367f, 0.0429096138f, -0.0752896400f, 0.1065626393f,
                        -0.1420889944f, 0.1999355085f, -0.3333314528f, 1.0f})
    tail = tail * t2 + c;
  const float octant = t * tail;
  const float quadrant = ay > ax ? kPi / 2 - octant : octant;
  return std::copysign(x < 0 ? kPi - quadrant : quadrant, y);
}

// a if c, else b, without a branch: for choices that nothing could predict.
inline float select(bool c, float a, float b) {
  const uint32_t mask = -static_cast<uint32_t>(c);
  return std::bit_cast<float>((std::bit_cast<uint32_t>(a) & mask) |
                              (std::bit_cast<uint32_t>(b) & ~mask));
}

// Concentric map of the square to the unit disk (Shirley and Chiu 1997).
inline Vec2 square_to_disk(Vec2 u) {
  const float a = 2 * u.x - 1, b = 2 * u.y - 1;
  if (a == 0 && b == 0) return {0, 0};
  const bool wide = std::abs(a) > std::abs(b);
  const float longer = select(wide, a, b), shorter = select(wide, b, a);
  const SinCos s = sin_cos_quarter(kPi / 4 * (shorter / longer));
  return {longer * select(wide, s.cos, s.sin), longer * select(wide, s.sin, s.cos)};
}

// 4/pi atan(t) for t in [0, 1] (Abramowitz and Stegun 1964, 4.4.49, shortened).
template <class Value>
constexpr Value disk_angle(const Value& t) {
  const Value t2 = t * t;
  return t *
         (1.2732104f +
          t2 * (-0.42350938f +
                t2 * (0.24642503f + t2 * (-0.14824690f + t2 * (0.06704038f + t2 * -0.01492391f)))));
}

// The inverse of square_to_disk(); within 2e-5. Results lie in [0, 1).
inline Vec2 disk_to_square(Vec2 d) {
  const float ax = std::abs(d.x), ay = std::abs(d.y);
  const float hi = std::max(ax, ay), lo = std::min(ax, ay);
  if (hi == 0) return {0.5f, 0.5f};
  const float far = std::sqrt(ax * ax + ay * ay), near = disk_angle(lo / hi) * far;
  const float a = std::copysign(select(ax >= ay, far, near), d.x);
  const float b = std::copysign(select(ax >= ay, near, far), d.y);
  return {std::clamp(0.5f * (a + 1), 0.0f, kOneMinusEpsilon),
          std::clamp(0.5f * (b + 1), 0.0f, kOneMinusEpsilon)};
}

// Density cos(theta) / pi.
inline Vec3 square_to_cosine_hemisphere(Vec2 u) {
  const Vec2 d = square_to_disk(u);
  return {d.x, d.y, std::sqrt(std::max(0.0f, 1 - d.x * d.x - d.y * d.y))};
}
inline float cosine_hemisphere_pdf_w(float cos_theta) { return std::max(0.0f, cos_theta) * kInvPi; }

// Density 1 / (2 pi). Equal areas of the disk become equal areas of the sphere: z = 1 - r^2.
inline Vec3 square_to_uniform_hemisphere(Vec2 u) {
  const Vec2 d = square_to_disk(u);
  const float r2 = d.x * d.x + d.y * d.y, scale = std::sqrt(std::max(0.0f, 2 - r2));
  return {d.x * scale, d.y * scale, std::max(0.0f, 1 - r2)};
}
constexpr float kUniformHemispherePdfW = 0.5f * kInvPi;

// Density 1 / (4 pi).
inline Vec3 square_to_uniform_sphere(Vec2 u) {
  const float z = 1 - 2 * u.x, r = std::sqrt(std::max(0.0f, 1 - z * z)), phi = 2 * kPi * u.y;
  return {r * std::cos(phi), r * std::sin(phi), z};
}
constexpr float kUniformSpherePdfW = 0.25f * kInvPi;

// On [0, 1), with the density that rises (or falls) linearly from a to b, neither negative and not
// both 0.
inline float sample_linear(float u, float a, float b) {
  if (u == 0 && a == 0) return 0;
  const float x = u * (a + b) / (a + std::sqrt(lerp(u, a * a, b * b)));
  return std::min(x, kOneMinusEpsilon);
}

// Barycentric coordinates (of the second and third vertex), uniform over the triangle
// (Heitz 2019, "A Low-Distortion Map Between Triangle and Square").
inline Vec2 square_to_triangle(Vec2 u) {
  if (u.y > u.x) {
    u.x *= 0.5f;
    u.y -= u.x;
  } else {
    u.y *= 0.5f;
    u.x -= u.y;
  }
  return u;
}

}  // namespace qray
