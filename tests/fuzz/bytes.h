// For targets whose inputs hold lengths and checksums that a blind change would break: their own
// mutators repair them, but for one input in kLeftBroken.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/byte_io.h"

extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t max_size);

namespace qray::fuzz {

constexpr unsigned kLeftBroken = 8;

// pre: there are 4 bytes at `offset`.
inline uint32_t get_u32(std::span<const uint8_t> bytes, size_t offset) {
  return ByteReader(bytes.subspan(offset, 4)).u32();
}
inline void put_u32(std::span<uint8_t> bytes, size_t offset, uint32_t value) {
  for (size_t i = 0; i < 4; ++i) bytes[offset + i] = static_cast<uint8_t>(value >> (8 * i));
}

}  // namespace qray::fuzz
