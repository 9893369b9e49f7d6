// Sixteen floats at once: GCC's vector types, which become one AVX-512 register, two of AVX2 or
// four of SSE by what a file is compiled for. Everything has internal linkage, since files of
// different targets include this.
#pragma once

#include <cstdint>
#include <cstring>

namespace qray {
namespace {

constexpr int kLanes = 16;
using Lanes = float __attribute__((vector_size(4 * kLanes)));
using IntLanes = int32_t __attribute__((vector_size(4 * kLanes)));

[[maybe_unused, gnu::always_inline]] inline Lanes load(const float* p) {
  Lanes v;
  std::memcpy(&v, p, sizeof v);
  return v;
}
[[maybe_unused, gnu::always_inline]] inline void store(float* p, const Lanes& v) {
  std::memcpy(p, &v, sizeof v);
}

// e^x for x in [-80, 60], clamped to it; within 3e-7 of it, relatively. For vectors V of floats and
// I of as many integers.
template <typename V, typename I>
[[maybe_unused, gnu::always_inline]] inline V exp_of(const V& x) {
  const V least = -80.0f - V{}, most = 60.0f - V{};
  V t = x < least ? least : x;
  t = (t > most ? most : t) * 1.44269504f;
  const V half = 0.5f - V{};
  const I n = __builtin_convertvector(t + (t < 0.0f ? -half : half), I);
  const V r = t - __builtin_convertvector(n, V);  // [-1/2, 1/2]
  V p = 1.5403530e-4f * r + 1.3333558e-3f;        // 2^r, Taylor
  p = p * r + 9.6181291e-3f;
  p = p * r + 5.5504109e-2f;
  p = p * r + 2.4022651e-1f;
  p = p * r + 6.9314718e-1f;
  p = p * r + 1.0f;
  return (V)((I)p + (n << 23));
}

[[maybe_unused, gnu::always_inline]] inline Lanes exp_lanes(const Lanes& x) {
  return exp_of<Lanes, IntLanes>(x);
}

}  // namespace
}  // namespace qray
