#include "core/base/byte_io.h"

#include <gtest/gtest.h>

#include <limits>

namespace qray {
namespace {

Bytes bytes_of(std::string_view text) { return Bytes(text.begin(), text.end()); }

TEST(Crc32c, PublishedVectors) {
  EXPECT_EQ(crc32c({}), 0u);
  EXPECT_EQ(crc32c(bytes_of("123456789")), 0xe3069283u);  // the usual check value
  // RFC 3720, appendix B.4.
  EXPECT_EQ(crc32c(Bytes(32, 0x00)), 0x8a9136aau);
  EXPECT_EQ(crc32c(Bytes(32, 0xff)), 0x62a8ab43u);
  Bytes up(32), down(32);
  for (uint8_t i = 0; i < 32; ++i) {
    up[i] = i;
    down[i] = static_cast<uint8_t>(31 - i);
  }
  EXPECT_EQ(crc32c(up), 0x46dd794eu);
  EXPECT_EQ(crc32c(down), 0x113fdb5cu);
}

TEST(Crc32c, ContinuesFromASeed) {
  const Bytes all = bytes_of("123456789"), head = bytes_of("1234"), tail = bytes_of("56789");
  EXPECT_EQ(crc32c(tail, crc32c(head)), crc32c(all));
}

TEST(ByteIo, LittleEndianOnPaper) {
  ByteWriter w;
  w.u8(0x01);
  w.u16(0x0203);
  w.u32(0x04050607);
  w.u64(0x08090a0b0c0d0e0f);
  w.i64(-2);
  w.f32(1.0f);
  w.f64(-2.0);
  w.string("ab");
  const Bytes expected{0x01, 0x03, 0x02, 0x07, 0x06, 0x05, 0x04, 0x0f, 0x0e, 0x0d, 0x0c,
                       0x0b, 0x0a, 0x09, 0x08, 0xfe, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff,
                       0xff, 0x00, 0x00, 0x80, 0x3f, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
                       0x00, 0xc0, 0x02, 0x00, 0x00, 0x00, 'a',  'b'};
  EXPECT_EQ(w.data(), expected);
}

TEST(ByteIo, ReadsWhatItWrote) {
  ByteWriter w;
  w.u8(255);
  w.u16(65535);
  w.u32(0xdeadbeef);
  w.u64(std::numeric_limits<uint64_t>::max());
  w.i64(std::numeric_limits<int64_t>::min());
  w.f32(-std::numeric_limits<float>::denorm_min());
  w.f64(std::numeric_limits<double>::infinity());
  w.string(std::string("a\0b", 3));
  w.bytes(bytes_of("tail"));
  ByteReader r(w.data());
  EXPECT_EQ(r.u8(), 255);
  EXPECT_EQ(r.u16(), 65535);
  EXPECT_EQ(r.u32(), 0xdeadbeef);
  EXPECT_EQ(r.u64(), std::numeric_limits<uint64_t>::max());
  EXPECT_EQ(r.i64(), std::numeric_limits<int64_t>::min());
  EXPECT_EQ(r.f32(), -std::numeric_limits<float>::denorm_min());
  EXPECT_EQ(r.f64(), std::numeric_limits<double>::infinity());
  EXPECT_EQ(r.string(3), std::string("a\0b", 3));
  EXPECT_EQ(r.remaining(), 4u);
  const auto tail = r.bytes(4);
  EXPECT_EQ(Bytes(tail.begin(), tail.end()), bytes_of("tail"));
  EXPECT_TRUE(r.ok());
}

TEST(ByteIo, PastTheEndStaysWrong) {
  const Bytes three{1, 2, 3};
  ByteReader r(three);
  EXPECT_EQ(r.u32(), 0u);
  EXPECT_FALSE(r.ok());
  EXPECT_EQ(r.u8(), 0u);  // though a byte is there
  EXPECT_TRUE(r.bytes(1).empty());
  EXPECT_FALSE(r.ok());
}

TEST(ByteIo, LongStringsAreRefusedBeforeTheyAreRead) {
  ByteWriter w;
  w.string("hello");
  ByteReader fits(w.data());
  EXPECT_EQ(fits.string(5), "hello");
  ByteReader limited(w.data());
  EXPECT_EQ(limited.string(4), "");
  EXPECT_FALSE(limited.ok());
  const Bytes lying{0xff, 0xff, 0xff, 0xff, 'x'};
  ByteReader r(lying);
  EXPECT_EQ(r.string(std::numeric_limits<size_t>::max()), "");
  EXPECT_FALSE(r.ok());
}

}  // namespace
}  // namespace qray
