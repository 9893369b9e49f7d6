#include "server/http/byte_range.h"

#include <gtest/gtest.h>

#include <string>

namespace qray::server {
namespace {

std::string parsed(std::string_view text, size_t whole = 100) {
  const std::optional<ByteRange> range = parse_range(text, whole);
  return range ? std::to_string(range->begin) + "+" + std::to_string(range->size) : "whole";
}

TEST(ByteRange, FirstLastAndRest) {
  EXPECT_EQ(parsed("bytes=0-0"), "0+1");
  EXPECT_EQ(parsed("bytes=10-19"), "10+10");
  EXPECT_EQ(parsed("bytes=90-1000"), "90+10");
  EXPECT_EQ(parsed("bytes=90-"), "90+10");
  EXPECT_EQ(parsed("bytes=-7"), "93+7");
  EXPECT_EQ(parsed("bytes=-700"), "0+100");
  EXPECT_EQ(parsed("bytes=0-99999999999999999999"), "0+100");
}

TEST(ByteRange, WhatIsNotThere) {
  EXPECT_EQ(parsed("bytes=100-"), "0+0");
  EXPECT_EQ(parsed("bytes=99999999999999999999-"), "0+0");
  EXPECT_EQ(parsed("bytes=-0"), "100+0");
  EXPECT_EQ(parsed("bytes=0-", 0), "0+0");
}

TEST(ByteRange, WhatIsNoRangeIsTheWhole) {
  for (const char* text : {"", "bytes", "bytes=", "bytes=-", "bytes=5", "bytes=5-4", "bytes=a-b",
                           "bytes=1-b", "bytes= 1-2", "bytes=+1-2", "bytes=1--2", "lines=1-2"})
    EXPECT_EQ(parsed(text), "whole") << text;
}

}  // namespace
}  // namespace qray::server
