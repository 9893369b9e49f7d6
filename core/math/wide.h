// Eight values side by side, for the same steps on each: one vector register of AVX, two of SSE.
// Every operation rounds as it does for one value, in the same order, so that what is computed here
// has the bits of core/math/vec.h, frame.h and warp.h (tests/core/math/wide_test.cpp). A "lane" is
// one of the eight places; sets of lanes are bits, lane 0 the lowest.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include "core/math/warp.h"

namespace qray {

constexpr int kWidth = 8;
constexpr uint32_t kAllLanes = (1u << kWidth) - 1;

using Wide = float __attribute__((vector_size(4 * kWidth)));
using WideInt = int32_t __attribute__((vector_size(4 * kWidth)));  // a mask: all bits or none
using WideUint = uint32_t __attribute__((vector_size(4 * kWidth)));

inline Wide wide(float v) { return v - Wide{}; }
inline Wide sqrt(const Wide& v) {
#ifdef __AVX__
  return __builtin_ia32_sqrtps256(v);
#else
  Wide root;
  for (int i = 0; i < kWidth; ++i) root[i] = std::sqrt(v[i]);
  return root;
#endif
}
inline Wide abs(const Wide& v) { return (Wide)((WideInt)v & 0x7fffffff); }
inline Wide copysign(const Wide& size, const Wide& sign) {
  constexpr int32_t kSign = std::numeric_limits<int32_t>::min();
  return (Wide)(((WideInt)size & ~kSign) | ((WideInt)sign & kSign));
}
// As std::max and std::min: of equal ones, or where one is no number, the first.
inline Wide max(const Wide& a, const Wide& b) { return a < b ? b : a; }
inline Wide min(const Wide& a, const Wide& b) { return b < a ? b : a; }

inline uint32_t lanes_of(const WideInt& mask) {
#ifdef __AVX__
  return static_cast<uint32_t>(__builtin_ia32_movmskps256((Wide)mask));
#else
  uint32_t lanes = 0;
  for (int i = 0; i < kWidth; ++i) lanes |= (mask[i] < 0 ? 1u : 0u) << i;
  return lanes;
#endif
}
inline WideInt mask_of(uint32_t lanes) {
  const WideInt bit{1, 2, 4, 8, 16, 32, 64, 128};
  return (bit & static_cast<int32_t>(lanes)) != 0;
}
// Calls body(lane) for each of them, the lowest first.
template <class Body>
inline void for_each_lane(uint32_t lanes, Body body) {
  for (; lanes; lanes &= lanes - 1) body(std::countr_zero(lanes));
}

struct WideVec2 {
  Wide x, y;
};
struct WideVec3 {
  Wide x, y, z;
};
inline WideVec3 operator+(const WideVec3& a, const WideVec3& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline WideVec3 operator-(const WideVec3& a, const WideVec3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline WideVec3 operator-(const WideVec3& a) { return {-a.x, -a.y, -a.z}; }
inline WideVec3 operator*(const WideVec3& a, const Wide& s) { return {a.x * s, a.y * s, a.z * s}; }
inline WideVec3 operator/(const WideVec3& a, const Wide& s) { return a * (1 / s); }
inline Wide dot(const WideVec3& a, const WideVec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Wide length(const WideVec3& a) { return sqrt(dot(a, a)); }
inline WideVec3 normalize(const WideVec3& a) { return a / length(a); }
inline WideVec3 select(const WideInt& mask, const WideVec3& a, const WideVec3& b) {
  return {mask ? a.x : b.x, mask ? a.y : b.y, mask ? a.z : b.z};
}

struct WideRgb {
  Wide r, g, b;
};
inline WideRgb operator*(const WideRgb& a, const WideRgb& b) {
  return {a.r * b.r, a.g * b.g, a.b * b.b};
}
inline WideRgb operator*(const WideRgb& a, const Wide& s) { return {a.r * s, a.g * s, a.b * s}; }
inline Wide luminance(const WideRgb& c) { return 0.2126f * c.r + 0.7152f * c.g + 0.0722f * c.b; }
inline WideInt is_black(const WideRgb& c) { return (c.r == 0) & (c.g == 0) & (c.b == 0); }

// Eight values in memory, which may be set and read lane by lane.
struct alignas(4 * kWidth) FloatLanes {
  float v[kWidth] = {};

  float& operator[](int lane) { return v[lane]; }
  float operator[](int lane) const { return v[lane]; }
  void operator=(const Wide& w) { std::memcpy(v, &w, sizeof v); }
  Wide wide() const {
    Wide w;
    std::memcpy(&w, v, sizeof v);
    return w;
  }
};
struct Vec2Lanes {
  FloatLanes x, y;

  Vec2 operator[](int lane) const { return {x[lane], y[lane]}; }
};
struct Vec3Lanes {
  FloatLanes x, y, z;

  Vec3 operator[](int lane) const { return {x[lane], y[lane], z[lane]}; }
  void set(int lane, Vec3 a) { x[lane] = a.x, y[lane] = a.y, z[lane] = a.z; }
  void operator=(const WideVec3& w) { x = w.x, y = w.y, z = w.z; }
  WideVec3 wide() const { return {x.wide(), y.wide(), z.wide()}; }
};
struct RgbLanes {
  FloatLanes r, g, b;

  Rgb operator[](int lane) const { return {r[lane], g[lane], b[lane]}; }
  void set(int lane, Rgb a) { r[lane] = a.r, g[lane] = a.g, b[lane] = a.b; }
  void operator=(const WideRgb& w) { r = w.r, g = w.g, b = w.b; }
  WideRgb wide() const { return {r.wide(), g.wide(), b.wide()}; }
};

// Frame, about the unit normals z.
struct WideFrame {
  WideVec3 x, y, z;

  WideFrame(const WideVec3& x_, const WideVec3& y_, const WideVec3& z_) : x(x_), y(y_), z(z_) {}
  explicit WideFrame(const WideVec3& n) : z(n) {
    const Wide sign = copysign(qray::wide(1), n.z);
    const Wide a = -1 / (sign + n.z);
    const Wide b = n.x * n.y * a;
    x = {1 + sign * (n.x * n.x) * a, sign * b, -sign * n.x};
    y = {b, sign + (n.y * n.y) * a, -n.y};
  }
  WideVec3 to_local(const WideVec3& v) const { return {dot(v, x), dot(v, y), dot(v, z)}; }
  WideVec3 to_world(const WideVec3& v) const { return x * v.x + y * v.y + z * v.z; }
};

// square_to_disk(), of the points (u, v).
inline WideVec2 square_to_disk(const Wide& u, const Wide& v) {
  const Wide a = 2 * u - 1, b = 2 * v - 1;
  const WideInt wide_one = abs(a) > abs(b);
  const Wide longer = wide_one ? a : b, shorter = wide_one ? b : a;
  const WideInt middle = longer == 0;
  const Wide x = middle ? Wide{} : kPi / 4 * (shorter / longer), x2 = x * x;
  const Wide sin =
      x * (1 + x2 * (-1 / 6.0f + x2 * (1 / 120.0f + x2 * (-1 / 5040.0f + x2 / 362880))));
  const Wide cos = 1 + x2 * (-1 / 2.0f + x2 * (1 / 24.0f + x2 * (-1 / 720.0f + x2 / 40320)));
  return {longer * (wide_one ? cos : sin), longer * (wide_one ? sin : cos)};
}

// square_to_cosine_hemisphere(), of the points (u, v).
inline WideVec3 square_to_cosine_hemisphere(const Wide& u, const Wide& v) {
  const WideVec2 d = square_to_disk(u, v);
  return {d.x, d.y, sqrt(max(Wide{}, 1 - d.x * d.x - d.y * d.y))};
}

// disk_to_square(), of the points (x, y).
inline WideVec2 disk_to_square(const Wide& x, const Wide& y) {
  const Wide ax = abs(x), ay = abs(y), hi = max(ax, ay), lo = min(ax, ay);
  const Wide r = sqrt(ax * ax + ay * ay), t = lo / hi;
  const Wide angle = disk_angle(t) * r;
  const WideInt along_x = ax >= ay;
  const auto side = [&](const Wide& a, const Wide& sign) {
    const Wide u = 0.5f * (copysign(a, sign) + 1);
    return hi == 0 ? wide(0.5f) : min(max(u, Wide{}), wide(kOneMinusEpsilon));
  };
  return {side(along_x ? r : angle, x), side(along_x ? angle : r, y)};
}

// square_to_triangle(), of the points (u, v).
inline WideVec2 square_to_triangle(const Wide& u, const Wide& v) {
  const WideInt above = v > u;
  const Wide half = 0.5f * (above ? u : v), rest = (above ? v : u) - half;
  return {above ? half : rest, above ? rest : half};
}

}  // namespace qray
