// Integer mixers. Not for untrusted keys.
#pragma once

#include <cstdint>

namespace qray {

// 64-bit finaliser of SplitMix64 (Steele et al. 2014).
constexpr uint64_t mix64(uint64_t v) {
  v += 0x9e3779b97f4a7c15ull;
  v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9ull;
  v = (v ^ (v >> 27)) * 0x94d049bb133111ebull;
  return v ^ (v >> 31);
}
constexpr uint64_t hash_combine(uint64_t a, uint64_t b) { return mix64(a ^ mix64(b)); }

// The top 24 bits as a float in [0, 1).
constexpr float to_unit_float(uint32_t v) { return static_cast<float>(v >> 8) * 0x1p-24f; }

}  // namespace qray
