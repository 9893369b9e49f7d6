// Explicit little-endian encoding of integers, floats and strings, with CRC-32C (Castagnoli,
// RFC 3720 section 12.1). Every binary file and message of qray is written through this or, where
// it is the state of a job, through snapshot.h, never as a raw struct. A reader past the end turns
// `ok()` false and returns zeros.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace qray {

using Bytes = std::vector<uint8_t>;

uint32_t crc32c(std::span<const uint8_t> bytes, uint32_t seed = 0);

class ByteWriter {
 public:
  void u8(uint8_t v) { bytes_.push_back(v); }
  void u16(uint16_t v) { put(v, 2); }
  void u32(uint32_t v) { put(v, 4); }
  void u64(uint64_t v) { put(v, 8); }
  void i64(int64_t v) { put(static_cast<uint64_t>(v), 8); }
  void f32(float v);
  void f64(double v);
  void bytes(std::span<const uint8_t> v) { bytes_.insert(bytes_.end(), v.begin(), v.end()); }
  void string(std::string_view v);  // u32 length, then the bytes

  const Bytes& data() const { return bytes_; }
  Bytes take() { return std::move(bytes_); }
  size_t size() const { return bytes_.size(); }

 private:
  void put(uint64_t v, int count) {
    for (int i = 0; i < count; ++i) bytes_.push_back(static_cast<uint8_t>(v >> (8 * i)));
  }
  Bytes bytes_;
};

class ByteReader {
 public:
  explicit ByteReader(std::span<const uint8_t> bytes) : bytes_(bytes) {}

  uint8_t u8() { return static_cast<uint8_t>(get(1)); }
  uint16_t u16() { return static_cast<uint16_t>(get(2)); }
  uint32_t u32() { return static_cast<uint32_t>(get(4)); }
  uint64_t u64() { return get(8); }
  int64_t i64() { return static_cast<int64_t>(get(8)); }
  float f32();
  double f64();
  std::span<const uint8_t> bytes(size_t count);
  std::string string(size_t max_size);  // a length over `max_size` counts as past the end

  bool ok() const { return ok_; }
  size_t offset() const { return offset_; }
  size_t remaining() const { return bytes_.size() - offset_; }

 private:
  uint64_t get(size_t count);
  std::span<const uint8_t> bytes_;
  size_t offset_ = 0;
  bool ok_ = true;
};

}  // namespace qray
