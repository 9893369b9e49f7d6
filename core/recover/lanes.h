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

// log x for normal x > 0; within 2e-7 of it, relatively where x >= 1. V and I as above.
template <typename V, typename I>
[[maybe_unused, gnu::always_inline]] inline V log_of(const V& x) {
  // x = 2^n (1 + r), 1 + r in [sqrt(1/2), sqrt(2)).
  const I n = ((I)x - 0x3f3504f3) >> 23;
  const V r = (V)((I)x - (n << 23)) - 1.0f;
  V p = 7.0376836e-2f * r - 1.1514610e-1f;  // Cephes, logf
  p = p * r + 1.1676998e-1f;
  p = p * r - 1.2420141e-1f;
  p = p * r + 1.4249323e-1f;
  p = p * r - 1.6668058e-1f;
  p = p * r + 2.0000714e-1f;
  p = p * r - 2.4999994e-1f;
  p = p * r + 3.3333331e-1f;
  const V square = r * r;
  return (r - 0.5f * square + p * r * square) + __builtin_convertvector(n, V) * 0.69314718f;
}

[[maybe_unused, gnu::always_inline]] inline Lanes exp_lanes(const Lanes& x) {
  return exp_of<Lanes, IntLanes>(x);
}

}  // namespace
}  // namespace qray
