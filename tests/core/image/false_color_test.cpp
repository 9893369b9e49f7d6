#include "core/image/false_color.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/image/tonemap.h"

namespace qray {
namespace {

void expect_same_color(Rgb a, Rgb b) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], 1e-4);
}

TEST(FalseColor, ViridisIsThePublishedOneAndRises) {
  expect_same_color(viridis(0), srgb_to_linear(Rgb{68, 1, 84} * (1 / 255.0f)));
  expect_same_color(viridis(0.5f), srgb_to_linear(Rgb{33, 145, 140} * (1 / 255.0f)));
  expect_same_color(viridis(1), srgb_to_linear(Rgb{253, 231, 37} * (1 / 255.0f)));
  for (int i = 1; i <= 100; ++i)
    EXPECT_GT(luminance(viridis(static_cast<float>(i) / 100)),
              luminance(viridis(static_cast<float>(i - 1) / 100)));
}

TEST(FalseColor, WhatIsOutsideHasTheColourOfTheEnd) {
  for (float v :
       {-1.0f, -std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()})
    EXPECT_EQ(viridis(v), viridis(0));
  EXPECT_EQ(viridis(std::numeric_limits<float>::infinity()), viridis(1));
}

TEST(FalseColor, TheLogarithmicScaleRunsFromLowToHigh) {
  EXPECT_FLOAT_EQ(log_scale(0.01f, 0.01f, 100), 0);
  EXPECT_FLOAT_EQ(log_scale(1, 0.01f, 100), 0.5f);
  EXPECT_FLOAT_EQ(log_scale(100, 0.01f, 100), 1);
  EXPECT_EQ(viridis(log_scale(0, 0.01f, 100)), viridis(0));
}

}  // namespace
}  // namespace qray
