#include "core/base/result.h"

#include <gtest/gtest.h>

#include <memory>

#include "core/base/ids.h"

namespace qray {
namespace {

TEST(Result, HoldsAValueOrAnError) {
  Result<std::unique_ptr<int>> good = std::make_unique<int>(7);
  ASSERT_TRUE(good.ok());
  EXPECT_EQ(*std::move(good).value(), 7);
  const Result<int> bad = Error{ErrorCode::kInvalid, "got 0, expected 1..4", "scene.json:/ior"};
  ASSERT_FALSE(bad.ok());
  EXPECT_EQ(bad.error().text(), "scene.json:/ior: got 0, expected 1..4");
  EXPECT_EQ((Error{ErrorCode::kBusy, "full", ""}).text(), "full");
}

TEST(Result, StatusIsOkUntilItIsNot) {
  EXPECT_TRUE(Status().ok());
  const Status status = Error{ErrorCode::kIo, "disk full", "a.exr"};
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::kIo);
}

TEST(ResultDeathTest, ReadingTheWrongOneIsABug) {
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  const Result<int> bad = Error{};
  EXPECT_DEATH((void)bad.value(), "QRAY_CHECK");
  const Result<int> good = 1;
  EXPECT_DEATH((void)good.error(), "QRAY_CHECK");
}

TEST(Ids, AreInvalidUntilGiven) {
  EXPECT_FALSE(MeshId().valid());
  EXPECT_TRUE(MeshId(0).valid());
  EXPECT_LT(MeshId(1), MeshId(2));
}

}  // namespace
}  // namespace qray
