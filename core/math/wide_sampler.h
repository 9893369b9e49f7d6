// Eight Samplers side by side: each lane has the numbers of its own, bit for bit.
#pragma once

#include "core/math/sampler.h"
#include "core/math/wide.h"

namespace qray {

class WideSampler {
 public:
  struct Pairs {
    Vec2Lanes a, b, c, d;
  };

  // The lane goes on as `sampler` would.
  void set(int lane, const Sampler& sampler) {
    key_[lane] = sampler.key_;
    reversed_index_[lane] = sampler.reversed_index_;
    pair_[lane] = sampler.pair_;
  }
  // Sampler::next_pairs() of every lane.
  void next_pairs(Pairs& pairs) {
    alignas(WideUint) uint32_t seeds[4][kWidth];
    for (int i = 0; i < kWidth; ++i) {
      const uint64_t h0 = Sampler::hash(key_[i], ++pair_[i]),
                     h1 = Sampler::hash(key_[i], ++pair_[i]);
      seeds[0][i] = static_cast<uint32_t>(h0);
      seeds[1][i] = static_cast<uint32_t>(h0 >> 32);
      seeds[2][i] = static_cast<uint32_t>(h1);
      seeds[3][i] = static_cast<uint32_t>(h1 >> 32);
    }
    WideUint index;
    std::memcpy(&index, reversed_index_, sizeof index);
    Vec2Lanes* const all[4] = {&pairs.a, &pairs.b, &pairs.c, &pairs.d};
    for (int k = 0; k < 4; ++k) {
      WideUint seed;
      std::memcpy(&seed, seeds[k], sizeof seed);
      const auto [x, y] = Sampler::point(index, seed);
      all[k]->x = to_unit_floats(x);
      all[k]->y = to_unit_floats(y);
    }
  }

 private:
  static Wide to_unit_floats(const WideUint& v) {
    return __builtin_convertvector((WideInt)(v >> 8), Wide) * 0x1p-24f;
  }

  uint64_t key_[kWidth] = {}, pair_[kWidth] = {};
  alignas(WideUint) uint32_t reversed_index_[kWidth] = {};
};

}  // namespace qray
