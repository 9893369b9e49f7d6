// Whole numbers in as few bytes as they need: seven bits each, the lowest first, the highest bit
// says that more follow (LEB128). Signed ones zigzag, so that small negative ones are short too.
#pragma once

#include "core/base/byte_io.h"

namespace qray {

inline void put_varint(ByteWriter& out, uint64_t v) {
  for (; v >= 0x80; v >>= 7) out.u8(static_cast<uint8_t>(v | 0x80));
  out.u8(static_cast<uint8_t>(v));
}
inline void put_signed_varint(ByteWriter& out, int64_t v) {
  put_varint(out, static_cast<uint64_t>(v) << 1 ^ static_cast<uint64_t>(v >> 63));
}

// Past the end, or longer than 64 bits: `in` is not ok any more, or false is returned.
inline bool get_varint(ByteReader& in, uint64_t& v) {
  v = 0;
  for (int shift = 0; shift < 64; shift += 7) {
    const uint8_t byte = in.u8();
    v |= static_cast<uint64_t>(byte & 0x7f) << shift;
    if (!in.ok()) return false;
    if (!(byte & 0x80)) return shift < 63 || byte <= 1;
  }
  return false;
}
inline bool get_signed_varint(ByteReader& in, int64_t& v) {
  uint64_t bits = 0;
  if (!get_varint(in, bits)) return false;
  v = static_cast<int64_t>(bits >> 1) ^ -static_cast<int64_t>(bits & 1);
  return true;
}

}  // namespace qray
