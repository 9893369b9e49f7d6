#include "core/image/tonemap.h"

#include <gtest/gtest.h>

namespace qray {
namespace {

TEST(Tonemap, IsTheStandardsCurve) {
  EXPECT_EQ(linear_to_srgb(0), 0);
  EXPECT_NEAR(linear_to_srgb(1), 1, 1e-6);
  EXPECT_NEAR(linear_to_srgb(0.18f), 0.461356, 1e-5);
  EXPECT_NEAR(srgb_to_linear(0.5f), 0.2140411, 1e-6);
  EXPECT_NEAR(linear_to_srgb(0.0031308f), 0.0404499, 1e-5);  // where the toe ends
}

TEST(Tonemap, GoesThereAndBack) {
  for (int i = 0; i <= 255; ++i) {
    const float display = static_cast<float>(i) / 255;
    EXPECT_NEAR(linear_to_srgb(srgb_to_linear(display)), display, 1e-5) << i;
  }
}

TEST(Tonemap, Clamps) {
  EXPECT_EQ(linear_to_srgb(-1), 0);
  EXPECT_NEAR(linear_to_srgb(100), 1, 1e-6);
  EXPECT_EQ(linear_to_srgb(std::nanf("")), 0);
}

}  // namespace
}  // namespace qray
