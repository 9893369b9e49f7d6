// MurmurHash3 of 32 bits with seed 0 (Austin Appleby, public domain), by which Cryptomatte numbers
// names. Pure.
#pragma once

#include <bit>
#include <cstdint>
#include <string_view>

namespace qray {

constexpr uint32_t murmur3_32(std::string_view text) {
  constexpr uint32_t kFirst = 0xcc9e2d51, kSecond = 0x1b873593;
  const auto scrambled = [](uint32_t k) { return std::rotl(k * kFirst, 15) * kSecond; };
  const auto byte = [text](size_t at) {
    return static_cast<uint32_t>(static_cast<unsigned char>(text[at]));
  };
  uint32_t hash = 0;
  size_t at = 0;
  for (; at + 4 <= text.size(); at += 4) {
    hash ^= scrambled(byte(at) | byte(at + 1) << 8 | byte(at + 2) << 16 | byte(at + 3) << 24);
    hash = std::rotl(hash, 13) * 5 + 0xe6546b64;
  }
  uint32_t rest = 0;
  for (size_t i = text.size(); i > at; --i) rest = rest << 8 | byte(i - 1);
  if (at < text.size()) hash ^= scrambled(rest);
  hash ^= static_cast<uint32_t>(text.size());
  hash = (hash ^ hash >> 16) * 0x85ebca6b;
  hash = (hash ^ hash >> 13) * 0xc2b2ae35;
  return hash ^ hash >> 16;
}

}  // namespace qray
