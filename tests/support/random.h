// Random numbers for tests: SplitMix64 (Steele et al. 2014), independent of the renderer's sampler.
// One per thread.
#pragma once

#include <cstdint>

#include "core/math/vec.h"

namespace qray::test {

class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}

  uint64_t next_u64() {
    uint64_t v = state_ += 0x9e3779b97f4a7c15ull;
    v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9ull;
    v = (v ^ (v >> 27)) * 0x94d049bb133111ebull;
    return v ^ (v >> 31);
  }
  uint32_t next_u32() { return static_cast<uint32_t>(next_u64() >> 32); }
  float next() { return static_cast<float>(next_u64() >> 40) * 0x1p-24f; }  // in [0, 1)
  Vec2 next_2d() {
    const float x = next();
    return {x, next()};
  }

 private:
  uint64_t state_;
};

}  // namespace qray::test
