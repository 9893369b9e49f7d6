#include "core/base/byte_io.h"

#include <array>
#include <bit>
#include <cstring>

namespace qray {
namespace {

constexpr std::array<uint32_t, 256> make_crc_table() {
  std::array<uint32_t, 256> table{};
  for (uint32_t i = 0; i < 256; ++i) {
    uint32_t c = i;
    for (int bit = 0; bit < 8; ++bit) c = (c & 1) ? 0x82f63b78u ^ (c >> 1) : c >> 1;
    table[i] = c;
  }
  return table;
}

constexpr std::array<uint32_t, 256> kCrcTable = make_crc_table();

}  // namespace

uint32_t crc32c(std::span<const uint8_t> bytes, uint32_t seed) {
  uint32_t c = ~seed;
#if defined(__SSE4_2__)  // the processor has an instruction for just this polynomial
  while (bytes.size() >= 8) {
    uint64_t eight;
    std::memcpy(&eight, bytes.data(), 8);
    c = static_cast<uint32_t>(__builtin_ia32_crc32di(c, eight));
    bytes = bytes.subspan(8);
  }
#endif
  for (uint8_t byte : bytes) c = kCrcTable[(c ^ byte) & 0xff] ^ (c >> 8);
  return ~c;
}

void ByteWriter::f32(float v) { u32(std::bit_cast<uint32_t>(v)); }
void ByteWriter::f64(double v) { u64(std::bit_cast<uint64_t>(v)); }

void ByteWriter::string(std::string_view v) {
  u32(static_cast<uint32_t>(v.size()));
  for (char c : v) u8(static_cast<uint8_t>(c));
}

uint64_t ByteReader::get(size_t count) {
  if (!ok_ || remaining() < count) {
    ok_ = false;
    return 0;
  }
  uint64_t v = 0;
  for (size_t i = 0; i < count; ++i) v |= static_cast<uint64_t>(bytes_[offset_ + i]) << (8 * i);
  offset_ += count;
  return v;
}

float ByteReader::f32() { return std::bit_cast<float>(u32()); }
double ByteReader::f64() { return std::bit_cast<double>(u64()); }

std::span<const uint8_t> ByteReader::bytes(size_t count) {
  if (!ok_ || remaining() < count) {
    ok_ = false;
    return {};
  }
  const std::span<const uint8_t> result = bytes_.subspan(offset_, count);
  offset_ += count;
  return result;
}

std::string ByteReader::string(size_t max_size) {
  const uint32_t size = u32();
  if (size > max_size) ok_ = false;
  const std::span<const uint8_t> raw = bytes(ok_ ? size : 0);
  return std::string(raw.begin(), raw.end());
}

}  // namespace qray
