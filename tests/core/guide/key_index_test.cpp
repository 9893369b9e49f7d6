#include "core/guide/key_index.h"

#include <gtest/gtest.h>

namespace qray {
namespace {

TEST(KeyIndex, FindsWhatWasInsertedInOrder) {
  KeyIndex index;
  EXPECT_FALSE(index.find(1).valid());
  constexpr uint32_t kCount = 20'000;
  for (uint32_t i = 0; i < kCount; ++i) EXPECT_EQ(index.find_or_insert(uint64_t{i} * 977).value, i);
  for (uint32_t i = 0; i < kCount; ++i) {
    EXPECT_EQ(index.find(uint64_t{i} * 977).value, i);
    EXPECT_EQ(index.find_or_insert(uint64_t{i} * 977).value, i);
    EXPECT_FALSE(index.find(uint64_t{i} * 977 + 1).valid());
  }
  EXPECT_EQ(index.size(), kCount);
}

}  // namespace
}  // namespace qray
