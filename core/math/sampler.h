// Owen-scrambled Sobol points: numbers depend on (seed, pixel, sample, dimension) alone, so a
// picture's bits depend on neither threads nor order. Dimensions are padded in pairs, each pair a
// shuffled, scrambled (0,2)-sequence (Burley 2020, "Practical Hash-based Owen Scrambling"); the
// scramble is the Laine-Karras hash with Burley's constants. One Sampler per thread.
#pragma once

#include <bit>
#include <cstdint>

#include "core/math/hash.h"
#include "core/math/vec.h"

namespace qray {

class Sampler {
 public:
  explicit Sampler(uint64_t seed) : seed_(mix64(seed)) {}

  void start(uint32_t x, uint32_t y, uint32_t sample) {
    key_ = mix64(seed_ ^ (static_cast<uint64_t>(y) << 32 | x));
    reversed_index_ = reverse_bits(sample);
    pair_ = 0;
  }

  // Four pairs of dimensions, each a point of its own two-dimensional net: what one vertex of a
  // path needs, made at once in vector registers.
  struct Pairs {
    Vec2 a, b, c, d;
  };
  Pairs next_pairs() {
    const uint64_t h0 = next_hash(), h1 = next_hash();
    const U32x4 seed{static_cast<uint32_t>(h0), static_cast<uint32_t>(h0 >> 32),
                     static_cast<uint32_t>(h1), static_cast<uint32_t>(h1 >> 32)};
    const auto [x, y] = point(U32x4{} + reversed_index_, seed);
    const F32x4 fx = to_unit_floats(x), fy = to_unit_floats(y);
    return {{fx[0], fy[0]}, {fx[1], fy[1]}, {fx[2], fy[2]}, {fx[3], fy[3]}};
  }

  // One pair of dimensions.
  Vec2 next_2d() {
    const uint32_t seed = static_cast<uint32_t>(next_hash());
    const auto [x, y] = point(reversed_index_, seed);
    return {to_unit_float(x), to_unit_float(y)};
  }

 private:
  friend class WideSampler;
  typedef uint32_t U32x4 __attribute__((vector_size(16)));
  typedef int32_t I32x4 __attribute__((vector_size(16)));
  typedef uint8_t U8x16 __attribute__((vector_size(16)));
  typedef uint32_t U32x8 __attribute__((vector_size(32)));
  typedef char S8x32 __attribute__((vector_size(32)));
  typedef float F32x4 __attribute__((vector_size(16)));

  static F32x4 to_unit_floats(U32x4 v) {
    return __builtin_convertvector((I32x4)(v >> 8), F32x4) * 0x1p-24f;
  }
  static uint32_t reverse_bits(uint32_t v) {
    v = __builtin_bswap32(v);
    v = (v & 0x0f0f0f0fu) << 4 | (v >> 4 & 0x0f0f0f0fu);
    v = (v & 0x33333333u) << 2 | (v >> 2 & 0x33333333u);
    return (v & 0x55555555u) << 1 | (v >> 1 & 0x55555555u);
  }
  // Each nibble is looked up reversed, then the bytes of each number change places.
  static U32x4 reverse_bits(U32x4 v) {
    constexpr U8x16 kNibble{0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15};
    constexpr U8x16 kOrder{3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12};
    const U8x16 low = (U8x16)(v & 0x0f0f0f0fu), high = (U8x16)(v >> 4 & 0x0f0f0f0fu);
    const U32x4 turned =
        (U32x4)__builtin_shuffle(kNibble, low) << 4 | (U32x4)__builtin_shuffle(kNibble, high);
    return (U32x4)__builtin_shuffle((U8x16)turned, kOrder);
  }

  static U32x8 reverse_bits(const U32x8& v) {
#ifdef __AVX2__
    constexpr S8x32 kNibble{0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15,
                            0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15};
    constexpr S8x32 kOrder{3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12,
                           3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12};
    const S8x32 low = (S8x32)(v & 0x0f0f0f0fu), high = (S8x32)(v >> 4 & 0x0f0f0f0fu);
    const U32x8 turned = (U32x8)__builtin_ia32_pshufb256(kNibble, low) << 4 |
                         (U32x8)__builtin_ia32_pshufb256(kNibble, high);
    return (U32x8)__builtin_ia32_pshufb256((S8x32)turned, kOrder);
#else
    U32x8 reversed;
    for (int i = 0; i < 8; ++i) reversed[i] = reverse_bits(static_cast<uint32_t>(v[i]));
    return reversed;
#endif
  }

  // The following hold for one number and for several.
  template <class U>
  struct Point {
    U x, y;
  };
  template <class U>
  static Point<U> point(const U& reversed_index, const U& seed) {
    const U index = reverse_bits(laine_karras(reversed_index, seed));
    return {reverse_bits(laine_karras(index, first_seed(seed))),
            reverse_bits(laine_karras(pascal(index), second_seed(seed)))};
  }
  // Owen scrambling of a bit-reversed number: every bit is flipped by a hash of the bits below.
  template <class U>
  static U laine_karras(U v, U seed) {
    v ^= v * 0x3d20adeau;
    v += seed;
    v *= (seed >> 16) | 1u;
    v ^= v * 0x05526c56u;
    v ^= v * 0x53a22864u;
    return v;
  }
  // Sobol's second generator matrix is Pascal's triangle modulo 2, the fifth Kronecker power of
  // [[1,1],[0,1]], so five steps multiply by it.
  template <class U>
  static U pascal(U v) {
    v ^= (v >> 1) & 0x55555555u;
    v ^= (v >> 2) & 0x33333333u;
    v ^= (v >> 4) & 0x0f0f0f0fu;
    v ^= (v >> 8) & 0x00ff00ffu;
    v ^= (v >> 16) & 0x0000ffffu;
    return v;
  }

  static uint64_t hash(uint64_t key, uint64_t pair) {
    return mix64(key + 0x9e3779b97f4a7c15ull * pair);
  }
  uint64_t next_hash() { return hash(key_, ++pair_); }
  // The two coordinates of a pair are scrambled apart from each other and from the shuffle.
  template <class U>
  static U first_seed(U seed) {
    return seed * 0x85ebca6bu + 0x165667b1u;
  }
  template <class U>
  static U second_seed(U seed) {
    return seed * 0x9e3779b1u + 0x7f4a7c15u;
  }

  uint64_t seed_;
  uint64_t key_ = 0;
  uint32_t reversed_index_ = 0;
  uint64_t pair_ = 0;
};

}  // namespace qray
