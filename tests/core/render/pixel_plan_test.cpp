#include "core/render/pixel_plan.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/math/sampler.h"
#include "core/render/tile_samples.h"
#include "tests/support/render.h"
#include "tests/support/stats.h"

namespace qray {
namespace {

constexpr int kPlanSide = 64;

RenderSettings settings(Pixels pixels) {
  RenderSettings s;
  s.width = s.height = 2 * kPlanSide;
  s.pixels = pixels;
  return s;
}

// Noise of a picture of mean 1 whose right half scatters `times` as much, against its mean. That of
// the left half is `left`.
NoiseEstimate uneven_noise(float times, float left = 1) {
  NoiseEstimate noise(kPlanSide, kPlanSide);
  noise.start_pass(false, false);
  for (int y = 0; y < kPlanSide; ++y)
    for (int x = 0; x < kPlanSide; ++x) {
      const bool is_left = x < kPlanSide / 2;
      const float off = (is_left ? 0.05f : 0.05f * times) * ((x + y) % 2 ? 1.0f : -1.0f);
      const float mean = is_left ? left : 1.0f, sum = 2 * mean;
      noise.add(x, y, 0, 4, {sum + off * mean, sum - off * mean, sum, sum}, 0);
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

// After a pass of so many, one of 16 by this noise.
PixelPlan second_pass(int first, const NoiseEstimate& noise) {
  PixelPlan plan(settings(Pixels::kByNoise));
  plan.start_pass(first, nullptr);
  plan.end_pass();
  plan.start_pass(16, &noise);
  return plan;
}

TEST(PixelPlan, WhatScattersMoreGetsMoreAndNoSampleIsLost) {
  PixelPlan plan = second_pass(16, uneven_noise(4));
  const double pixels = kPlanSide * kPlanSide;
  EXPECT_NEAR(static_cast<double>(total(plan)), 16 * pixels, 0.01 * 16 * pixels);
  // 16 a pixel, in proportion 1 : 4^0.7.
  EXPECT_NEAR(plan.count(10, 30), 8.8, 1.2);
  EXPECT_NEAR(plan.count(50, 30), 23.2, 1.2);
  plan.end_pass();
  EXPECT_EQ(plan.first(50, 30), 16 + plan.count(50, 30));
}

TEST(PixelPlan, NoPixelIsLeftOut) {
  EXPECT_GE(second_pass(16, uneven_noise(1000)).count(10, 30), 7u);
}

TEST(PixelPlan, AllAreAlikeWhereLittleIsKnownOrToBeGained) {
  struct {
    const char* what;
    int first;
    float times, left;
  } const cases[] = {
      {"few samples", 15, 4, 1}, {"nearly even", 16, 1.4f, 1}, {"dark pixels pay", 16, 1, 0.3f}};
  for (const auto& [what, first, times, left] : cases) {
    PixelPlan plan = second_pass(first, uneven_noise(times, left));
    EXPECT_EQ(plan.count(10, 30), 16u) << what;
    EXPECT_EQ(plan.count(50, 30), 16u) << what;
    plan.end_pass();
    EXPECT_EQ(plan.first(50, 30), static_cast<uint32_t>(first) + 16) << what;
  }
}

// The mean of a picture whose samples are 100 once in 100 times, else 0.
double mean_of_rare_light(const RenderSettings& settings, Sampler& random) {
  PixelPlan plan(settings);
  NoiseEstimate noise(plan.width(), plan.height());
  Film film(plan.width(), plan.height());
  TileSamples tile;
  for (const int samples : {1, 2, 3, 4, 6, 8, 12, 16}) {
    plan.start_pass(samples, &noise);
    noise.start_pass(false, false);
    tile.start(film.tile(0));
    plan.for_each_in_round(0, film.tile(0), [&](int x, int y) {
      const uint32_t first = plan.first(x, y), count = plan.count(x, y);
      tile.set_count(x, y, count);
      for (uint32_t n = first; n < first + count; ++n)
        *tile.target(x, y, first, count, n).radiance +=
            Rgb{random.next_2d().x < 0.01f ? 100 : 0.0f};
      const SampleHalves<Rgb> of = tile.halves(x, y);
      noise.add(x, y, first, count, {of.even.r, of.odd.r, of.earlier.r, of.later.r}, {});
      return true;
    });
    film.add(0, tile.sums(), static_cast<uint32_t>(samples), tile.counts(), {}, {},
             static_cast<uint32_t>(samples));
    plan.end_pass();
    noise.end_pass();
  }
  return test::mean_luminance(film.develop());
}

TEST(PixelPlan, CountsByNoiseLeaveTheMeanRight) {
  RenderSettings s = settings(Pixels::kAll);
  s.method = "adaptive";
  s.adaptive.by_noise = true;
  s.width = s.height = Film::kTilePx;
  test::Moments means;
  for (uint32_t picture = 0; picture < 40; ++picture) {
    Sampler random(picture);
    random.start(0, 0, 1);
    means.add(mean_of_rare_light(s, random));
  }
  // Were every sample weighed the same, it would be .985.
  EXPECT_GT(test::z_test(means, 1).p_value, test::significance(1)) << means.mean();
  EXPECT_LT(means.standard_error(), 0.01);
}

TEST(PixelPlan, CountsGoByNoiseWhereTheMethodIsAdaptiveAndNoRegionComesFirst) {
  RenderSettings s = settings(Pixels::kAll);
  s.method = "adaptive";
  s.adaptive.by_noise = true;
  EXPECT_TRUE(PixelPlan(s).by_noise());
  EXPECT_FALSE(PixelPlan(s, /*in_rounds=*/true).by_noise());
  for (const auto& change : std::initializer_list<void (*)(RenderSettings&)>{
           [](RenderSettings& r) { r.method = "none"; },
           [](RenderSettings& r) { r.adaptive.by_noise = false; },
           [](RenderSettings& r) { r.pixels = Pixels::kQuarter; },
           [](RenderSettings& r) {
             r.region = {1, 1, 2, 2};
           }}) {
    RenderSettings other = s;
    change(other);
    EXPECT_FALSE(PixelPlan(other).by_noise());
  }
}

// Runs passes of so many samples; what a pixel in the region and one outside have by the end of
// each.
struct Ahead {
  std::vector<uint32_t> inside, outside;
};
Ahead with_region(RenderSettings s, const std::vector<int>& passes) {
  s.region = {10, 20, 30, 40};
  PixelPlan plan(s);
  Ahead out;
  for (const int samples : passes) {
    plan.start_pass(samples, nullptr);
    EXPECT_EQ(plan.first(9, 20), plan.first(40, 60));
    out.inside.push_back(plan.first(10, 20) + plan.count(10, 20));
    out.outside.push_back(plan.first(9, 20) + plan.count(9, 20));
    EXPECT_EQ(plan.first(39, 59) + plan.count(39, 59), out.inside.back());
    plan.end_pass();
    EXPECT_EQ(plan.first(10, 20), out.inside.back());
  }
  return out;
}

TEST(PixelPlan, ARegionHasItsSamplesFirstAndInTheEndAllHaveAsMany) {
  RenderSettings s = settings(Pixels::kAll);
  s.samples = 40;
  const Ahead ahead = with_region(s, {1, 1, 2, 4, 8, 16, 8});
  EXPECT_EQ(ahead.inside, (std::vector<uint32_t>{1, 14, 40, 40, 40, 40, 40}));
  EXPECT_EQ(ahead.outside.front(), 1u);  // the first pass shows all of the picture
  EXPECT_EQ(ahead.outside[1], 1u);
  EXPECT_EQ(ahead.outside.back(), 40u);
}

TEST(PixelPlan, WhereTimeEndsTheJobARegionHasHalfOfTheSamples) {
  RenderSettings s = settings(Pixels::kAll);
  s.samples = 0;
  s.seconds = 60;
  const Ahead ahead = with_region(s, {1, 1, 2, 4, 8});
  const double region = 30 * 40, all = 4 * kPlanSide * kPlanSide;
  EXPECT_NEAR(ahead.inside.back() * region, 15 * all / 2, 0.1 * 15 * all);
  EXPECT_NEAR(ahead.outside.back() * (all - region), 15 * all / 2, 0.1 * 15 * all);
}

TEST(PixelPlan, ARegionWithoutASampledPixelChangesNothing) {
  RenderSettings s = settings(Pixels::kQuarter);
  s.region = {1, 1, 1, 1};
  PixelPlan plan(s);
  for (const int samples : {1, 2, 4}) {
    plan.start_pass(samples, nullptr);
    EXPECT_EQ(total(plan), static_cast<uint64_t>(samples) * plan.pixels());
    plan.end_pass();
  }
}

}  // namespace
}  // namespace qray
