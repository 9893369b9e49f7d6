#include "core/base/varint.h"

#include <gtest/gtest.h>

namespace qray {
namespace {

TEST(Varint, ComesBackInFewBytes) {
  ByteWriter out;
  const uint64_t numbers[] = {0, 1, 127, 128, 300, uint64_t{1} << 35, UINT64_MAX};
  const int64_t signed_numbers[] = {0, -1, 1, -64, 64, INT64_MIN, INT64_MAX};
  for (const uint64_t n : numbers) put_varint(out, n);
  EXPECT_EQ(out.size(), 1u + 1 + 1 + 2 + 2 + 6 + 10);
  for (const int64_t n : signed_numbers) put_signed_varint(out, n);
  ByteReader in(out.data());
  for (const uint64_t n : numbers) {
    uint64_t v = 0;
    ASSERT_TRUE(get_varint(in, v));
    EXPECT_EQ(v, n);
  }
  for (const int64_t n : signed_numbers) {
    int64_t v = 0;
    ASSERT_TRUE(get_signed_varint(in, v));
    EXPECT_EQ(v, n);
  }
  EXPECT_EQ(in.remaining(), 0u);
}

TEST(Varint, WhatIsCutOffOrTooLongIsRefused) {
  uint64_t v = 0;
  for (const Bytes& bytes : {Bytes{}, Bytes{0x80}, Bytes(10, 0xff), Bytes(11, 0x80)}) {
    ByteReader in(bytes);
    EXPECT_FALSE(get_varint(in, v)) << bytes.size();
  }
}

}  // namespace
}  // namespace qray
