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

  // One pair of dimensions, a point of a two-dimensional net.
  Vec2 next_2d() {
    const uint64_t h = mix64(key_ + 0x9e3779b97f4a7c15ull * ++pair_);
    const uint32_t index = reverse_bits(laine_karras(reversed_index_, static_cast<uint32_t>(h)));
    const uint32_t seed_x = static_cast<uint32_t>(h >> 32);
    const uint32_t seed_y = seed_x * 0x9e3779b9u + 0x7f4a7c15u;
    return {to_unit_float(reverse_bits(laine_karras(index, seed_x))),
            to_unit_float(reverse_bits(laine_karras(pascal(index), seed_y)))};
  }
  float next_1d() { return next_2d().x; }

  static constexpr uint32_t reverse_bits(uint32_t v) {
    v = __builtin_bswap32(v);
    v = (v & 0x0f0f0f0fu) << 4 | (v >> 4 & 0x0f0f0f0fu);
    v = (v & 0x33333333u) << 2 | (v >> 2 & 0x33333333u);
    return (v & 0x55555555u) << 1 | (v >> 1 & 0x55555555u);
  }
  // Owen scrambling of a bit-reversed number: every bit is flipped by a hash of the bits below.
  static constexpr uint32_t laine_karras(uint32_t v, uint32_t seed) {
    v ^= v * 0x3d20adeau;
    v += seed;
    v *= (seed >> 16) | 1;
    v ^= v * 0x05526c56u;
    v ^= v * 0x53a22864u;
    return v;
  }
  // Sobol's second generator matrix is Pascal's triangle modulo 2, the fifth Kronecker power of
  // [[1,1],[0,1]], so five steps multiply by it.
  static constexpr uint32_t pascal(uint32_t v) {
    v ^= (v >> 1) & 0x55555555u;
    v ^= (v >> 2) & 0x33333333u;
    v ^= (v >> 4) & 0x0f0f0f0fu;
    v ^= (v >> 8) & 0x00ff00ffu;
    v ^= (v >> 16) & 0x0000ffffu;
    return v;
  }

 private:
  uint64_t seed_;
  uint64_t key_ = 0;
  uint32_t reversed_index_ = 0;
  uint64_t pair_ = 0;
};

}  // namespace qray
