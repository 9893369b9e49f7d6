#include "core/recover/shrink.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/image/metrics.h"
#include "tests/support/random.h"

namespace qray {
namespace {

constexpr int kShrinkSide = 48;  // pixels

Image plain(float value, int channels = 3) {
  Image image(kShrinkSide, kShrinkSide, channels);
  for (float& v : image.data()) v = value;
  return image;
}

// Pixels of mean 1 and the given standard error, as two halves show it.
struct Sampled {
  Image colour = plain(0), own_error = plain(0, 1);
};
Sampled sampled(float error, uint64_t seed) {
  test::Random random(seed);
  Sampled s;
  for (int y = 0; y < kShrinkSide; ++y)
    for (int x = 0; x < kShrinkSide; ++x) {
      const auto half = [&] {
        return 1 + error * std::sqrt(2.0f) * (random.next() < 0.5f ? -1 : 1);
      };
      const float even = half(), odd = half();
      s.colour.set_rgb(x, y, Rgb{(even + odd) / 2});
      s.own_error.at(x, y, 0) = std::abs(even - odd) / 2;
    }
  return s;
}

TEST(Shrink, AWrongGuessGivesWayAsNoiseFalls) {
  TaskPool pool(2);
  const Image truth = plain(1), guess = plain(0.8f);
  double before = relmse(guess, truth);
  for (const float error : {0.2f, 0.05f, 0.0125f}) {
    const Sampled s = sampled(error, 1);
    const double raw = relmse(s.colour, truth);
    const double shrunk = relmse(shrink_towards(guess, s.colour, s.own_error, pool), truth);
    EXPECT_LT(shrunk, 1.05 * raw) << error;
    EXPECT_LT(shrunk, 0.8 * before) << error;
    before = shrunk;
  }
}

TEST(Shrink, AGoodGuessIsKept) {
  TaskPool pool(2);
  const Sampled s = sampled(0.5f, 2);
  const Image shrunk = shrink_towards(plain(1), s.colour, s.own_error, pool);
  EXPECT_LT(relmse(shrunk, plain(1)), 0.1 * relmse(s.colour, plain(1)));
}

TEST(Shrink, NothingIsTakenOfSamplesWhoseNoiseIsNotKnown) {
  TaskPool pool(1);
  const Image guess = plain(0.5f);
  const Image shrunk = shrink_towards(guess, sampled(0.1f, 3).colour,
                                      plain(std::numeric_limits<float>::infinity(), 1), pool);
  EXPECT_EQ(relmse(shrunk, guess), 0);
}

TEST(Shrink, AFireflyDoesNotComeBackWhereTheGuessIsWrong) {
  TaskPool pool(1);
  Sampled s = sampled(0.02f, 4);
  // One of its two halves: the pixel's mean and its error are alike.
  s.colour.set_rgb(24, 24, Rgb{1000});
  s.own_error.at(24, 24, 0) = 1000;
  const Image shrunk = shrink_towards(plain(0.8f), s.colour, s.own_error, pool);
  EXPECT_LT(shrunk.rgb(24, 24).g, 1.5f);
  EXPECT_NEAR(shrunk.rgb(8, 24).g, 1, 0.1f) << "far from it samples count";
}

// Light of mean 1 that one pixel of `rarity` meets, in one of its halves.
Sampled rare(float rarity, uint64_t seed) {
  test::Random random(seed);
  Sampled s;
  for (int y = 0; y < kShrinkSide; ++y)
    for (int x = 0; x < kShrinkSide; ++x) {
      const float light = random.next() * rarity < 1 ? rarity : 0.0f;
      s.colour.set_rgb(x, y, Rgb{light});
      s.own_error.at(x, y, 0) = light;
    }
  return s;
}

TEST(Shrink, PixelsThatMetNoRareLightAreNotSureThatThereIsNone) {
  TaskPool pool(2);
  const Sampled s = rare(100, 6);
  EXPECT_LT(relmse(shrink_towards(plain(1), s.colour, s.own_error, pool), plain(1)), 0.02);
}

TEST(Shrink, DarknessBesideCommonLightIsBelieved) {
  TaskPool pool(2);
  Sampled s = rare(2, 7);
  for (int y = 0; y < kShrinkSide; ++y)
    for (int x = 24; x < kShrinkSide; ++x) {
      s.colour.set_rgb(x, y, Rgb{});
      s.own_error.at(x, y, 0) = 0;
    }
  const Image shrunk = shrink_towards(plain(1), s.colour, s.own_error, pool);
  for (int y = 0; y < kShrinkSide; ++y)
    for (int x = 28; x < kShrinkSide; ++x) ASSERT_LT(shrunk.at(x, y, 0), 0.05f) << x << ", " << y;
}

TEST(Shrink, DoesNotDependOnThreads) {
  TaskPool one(1), three(3);
  const Sampled s = sampled(0.3f, 5);
  EXPECT_EQ(relmse(shrink_towards(plain(0.9f), s.colour, s.own_error, one),
                   shrink_towards(plain(0.9f), s.colour, s.own_error, three)),
            0);
}

}  // namespace
}  // namespace qray
