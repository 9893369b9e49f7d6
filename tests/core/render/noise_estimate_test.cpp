#include "core/render/noise_estimate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "core/math/vec.h"
#include "tests/support/random.h"

namespace qray {
namespace {

constexpr int kNoiseSide = 64;
constexpr double kLike = 1.25;  // what a variance is set against where all means are 1

// A pass of samples of mean 1 and the given standard deviation, whose guide saved each so much.
void render(NoiseEstimate& noise, uint64_t& done, int samples, bool guided, float deviation,
            test::Random& random, double saved = 0) {
  noise.start_pass(guided, /*learning=*/true);
  const auto first = static_cast<uint32_t>(done), count = static_cast<uint32_t>(samples);
  const uint32_t earlier = TileSamples::even_count(first, count);
  for (int y = 0; y < kNoiseSide; ++y)
    for (int x = 0; x < kNoiseSide; ++x) {
      SampleHalves<float> of{};
      for (uint32_t s = 0; s < count; ++s) {
        const float sample = 1 + deviation * (random.next() < 0.5f ? -1.0f : 1.0f);
        ((first + s) % 2 ? of.odd : of.even) += sample;
        (s < earlier ? of.earlier : of.later) += sample;
      }
      noise.add(x, y, first, count, of, saved * samples);
    }
  done += static_cast<uint64_t>(samples);
}

TEST(NoiseEstimate, TwoPassesOfOneSampleMakeAnEstimate) {
  NoiseEstimate noise(kNoiseSide, kNoiseSide);
  test::Random random(1);
  uint64_t done = 0;
  EXPECT_EQ(noise.deviation(3, 3), 0);
  render(noise, done, 1, false, 0.5f, random);
  EXPECT_FALSE(noise.end_pass());
  render(noise, done, 1, false, 0.5f, random);
  EXPECT_TRUE(noise.end_pass());
  EXPECT_NEAR(noise.variance(), 0.25 / kLike, 0.03);
  EXPECT_EQ(noise.guided_variance(), 0) << "no pixel was guided";
}

TEST(NoiseEstimate, OnlyLearningPassesTellWhatTheGuideSaves) {
  NoiseEstimate noise(kNoiseSide, kNoiseSide);
  for (const bool learning : {true, false}) {
    noise.start_pass(/*guided=*/true, learning);
    for (int y = 0; y < kNoiseSide; ++y)
      for (int x = 0; x < kNoiseSide; ++x) noise.add(x, y, 0, 2, {0.9f, 1.1f, 1, 1}, 2 * 0.38);
    ASSERT_TRUE(noise.end_pass());
    EXPECT_NEAR(noise.variance(), 0.02 / kLike, 1e-6);
    EXPECT_NEAR(noise.unguided_variance(), learning ? 0.4 / kLike : 0, 1e-6);
  }
}

TEST(NoiseEstimate, WhereSomePixelsAreGuidedTheyAreMeasuredAlone) {
  NoiseEstimate noise(kNoiseSide, kNoiseSide);
  noise.start_pass(/*guided=*/true, /*learning=*/true);
  for (int y = 0; y < kNoiseSide; ++y)
    for (int x = 0; x < kNoiseSide; ++x)
      if (x % 4 == 0)
        noise.add(x, y, 0, 2, {0.9f, 1.1f, 1, 1}, 2 * 0.38);
      else
        noise.add(x, y, 0, 2, {0.5f, 1.5f, 1, 1}, std::nullopt);
  ASSERT_TRUE(noise.end_pass());
  EXPECT_NEAR(noise.variance(), (0.02 + 3 * 0.5) / 4 / kLike, 2e-3);
  EXPECT_NEAR(noise.guided_variance(), 0.02 / kLike, 1e-6);
  EXPECT_NEAR(noise.unguided_variance(), 0.4 / kLike, 1e-6);
}

TEST(NoiseEstimate, AnyPassTellsTheVarianceOfItsSamples) {
  for (int samples : {2, 3, 8, 33}) {
    NoiseEstimate noise(kNoiseSide, kNoiseSide);
    test::Random random(2);
    uint64_t done = 5;
    render(noise, done, samples, true, 0.3f, random);
    ASSERT_TRUE(noise.end_pass());
    EXPECT_NEAR(noise.variance(), 0.09 / kLike, 0.012) << samples;
  }
}

TEST(NoiseEstimate, APixelsOwnErrorIsOfAllItsSamples) {
  NoiseEstimate noise(kNoiseSide, kNoiseSide);
  test::Random random(4);
  uint64_t done = 0;
  render(noise, done, 1, false, 0.5f, random);
  EXPECT_EQ(noise.own_error(3, 3), std::numeric_limits<float>::infinity());
  for (int samples : {1, 3, 8, 9}) render(noise, done, samples, true, 0.5f, random);
  double square = 0;
  for (int y = 0; y < kNoiseSide; ++y)
    for (int x = 0; x < kNoiseSide; ++x) square += sqr(double{noise.own_error(x, y)});
  EXPECT_NEAR(square / (kNoiseSide * kNoiseSide), 0.25 / 22, 0.06 * 0.25 / 22);
}

TEST(NoiseEstimate, AFireflyIsItsPixelsOwnError) {
  NoiseEstimate noise(1, 1);
  noise.start_pass(false, false);
  noise.add(0, 0, 0, 4, {202, 202, 400, 4}, 0);  // 2 samples each
  EXPECT_FLOAT_EQ(noise.own_error(0, 0), 99) << "the mean is 101, all but 2 of it by one half";
}

TEST(NoiseEstimate, IsTheSameInAnyUnitOfLight) {
  double variance = 0;
  const auto spread = [&variance](float unit) {
    NoiseEstimate noise(kNoiseSide, kNoiseSide);
    noise.start_pass(false, false);
    for (int y = 0; y < kNoiseSide; ++y)
      for (int x = 0; x < kNoiseSide; ++x) {
        const float mean = x < kNoiseSide / 2 ? unit : 0;  // the other half is black, and noisy
        const float off = (x + y) % 2 ? 0.1f * unit : -0.1f * unit;
        noise.add(x, y, 0, 2, {mean + off, mean - off, mean, mean}, {});
      }
    EXPECT_TRUE(noise.end_pass());
    variance = noise.variance();
    return noise.spread();
  };
  const std::vector<float> of_one = spread(1);
  const double variance_of_one = variance;
  EXPECT_GT(variance_of_one, 0);
  for (const float unit : {0x1p-40f, 0x1p30f}) {
    EXPECT_EQ(spread(unit), of_one);
    EXPECT_EQ(variance, variance_of_one);
  }
  EXPECT_EQ(spread(0), std::vector<float>(size_t{kNoiseSide} * kNoiseSide));
  EXPECT_EQ(variance, 0);
  // A sample's deviation is .141, which the mean distance of a normal variable makes .177. The
  // median of what is lit, 1, stands beside the mean, and alone for what is black.
  EXPECT_NEAR(of_one[10], 0.177f / std::sqrt(2.0f), 1e-3f);
  EXPECT_NEAR(of_one[kNoiseSide - 10], 0.177f, 1e-3f);
}

TEST(NoiseEstimate, GuidedPassesAreKeptApart) {
  NoiseEstimate noise(kNoiseSide, kNoiseSide);
  test::Random random(3);
  uint64_t done = 0;
  render(noise, done, 4, false, 0.5f, random);
  noise.end_pass();
  render(noise, done, 1, false, 100, random);  // half an estimate: lost
  EXPECT_FALSE(noise.end_pass());
  for (int pass = 0; pass < 2; ++pass) {
    render(noise, done, 4, true, 0.1f, random, /*saved=*/0.24);
    ASSERT_TRUE(noise.end_pass());
  }
  // What it would be unguided: the guided passes' own, and what they saved.
  const double ratio = noise.unguided_variance() / noise.variance();
  EXPECT_NEAR(ratio, 25, 4);
  EXPECT_NEAR(noise.variance_before() / noise.variance(), 1, 0.2);
  EXPECT_NEAR(noise.deviation(20, 20), 0.1f, 0.15f) << "fades from 0.5 toward 0.1";
}

// What seems quiet has more likely missed rare light than found less noise.
TEST(NoiseEstimate, EarlierSamplesNeverCountMoreThanLaterOnes) {
  for (const auto& [before, after, weight] : {std::tuple{0.4f, 0.2f, 0.25f}, {0.2f, 0.4f, 1.0f}}) {
    NoiseEstimate noise(kNoiseSide, kNoiseSide);
    test::Random random(5);
    uint64_t done = 0;
    render(noise, done, 8, false, before, random);
    ASSERT_TRUE(noise.end_pass());
    EXPECT_EQ(noise.weight_of_earlier(), 1) << "not known";
    render(noise, done, 8, true, after, random);
    ASSERT_TRUE(noise.end_pass());
    EXPECT_NEAR(noise.weight_of_earlier(), weight, 0.05f);
  }
}

}  // namespace
}  // namespace qray
