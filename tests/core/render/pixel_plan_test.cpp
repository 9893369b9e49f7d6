#include "core/render/pixel_plan.h"

#include <gtest/gtest.h>

namespace qray {
namespace {

constexpr int kPlanSide = 64;

RenderSettings settings(Pixels pixels) {
  RenderSettings s;
  s.width = s.height = 2 * kPlanSide;
  s.pixels = pixels;
  return s;
}

// Noise of a picture of mean 1 whose right half scatters `times` as much.
NoiseEstimate uneven_noise(float times) {
  NoiseEstimate noise(kPlanSide, kPlanSide);
  noise.start_pass(false, false);
  for (int y = 0; y < kPlanSide; ++y)
    for (int x = 0; x < kPlanSide; ++x) {
      const float off = (x < kPlanSide / 2 ? 0.05f : 0.05f * times) * ((x + y) % 2 ? 1.0f : -1.0f);
      noise.add(x, y, 0, 4, {2 + off, 2 - off, 2, 2}, 0);
    }
  EXPECT_TRUE(noise.end_pass());
  return noise;
}

uint64_t total(const PixelPlan& plan) {
  uint64_t sum = 0;
  for (int y = 0; y < plan.height(); ++y)
    for (int x = 0; x < plan.width(); ++x) sum += plan.count(x, y);
  return sum;
}

TEST(PixelPlan, AQuarterIsOneOfEachBlock) {
  PixelPlan all(settings(Pixels::kAll)), quarter(settings(Pixels::kQuarter));
  EXPECT_EQ(all.width(), 2 * kPlanSide);
  EXPECT_EQ(quarter.width(), kPlanSide);
  EXPECT_EQ(quarter.step(), 2);
  quarter.start_pass(3, nullptr);
  EXPECT_EQ(quarter.count(5, 7), 3u);
  quarter.end_pass();
  quarter.start_pass(2, nullptr);
  EXPECT_EQ(quarter.first(5, 7), 3u);
}

TEST(PixelPlan, WhatScattersMoreGetsMoreAndNoSampleIsLost) {
  const NoiseEstimate noise = uneven_noise(4);
  PixelPlan plan(settings(Pixels::kByNoise));
  plan.start_pass(4, nullptr);  // nothing is known yet
  EXPECT_EQ(plan.count(0, 0), 4u);
  plan.end_pass();
  plan.start_pass(16, &noise);
  const double pixels = kPlanSide * kPlanSide;
  EXPECT_NEAR(static_cast<double>(total(plan)), 16 * pixels, 0.01 * 16 * pixels);
  // 20 a pixel in all, in proportion 1 : 4.
  EXPECT_NEAR(plan.first(10, 30) + plan.count(10, 30), 8, 1.5);
  EXPECT_NEAR(plan.first(50, 30) + plan.count(50, 30), 32, 1.5);
  plan.end_pass();
  EXPECT_EQ(plan.first(50, 30), 4 + plan.count(50, 30));
}

TEST(PixelPlan, NoPixelIsLeftOut) {
  const NoiseEstimate noise = uneven_noise(1000);
  PixelPlan plan(settings(Pixels::kByNoise));
  plan.start_pass(2, nullptr);
  plan.end_pass();
  plan.start_pass(30, &noise);
  EXPECT_GE(plan.first(10, 30) + plan.count(10, 30), 5u);
}

}  // namespace
}  // namespace qray
