#include "core/recover/balance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/image/metrics.h"
#include "tests/support/random.h"

namespace qray {
namespace {

constexpr int kBalanceSide = 192;  // pixels
constexpr int kSquarePx = 64;
constexpr int kBrighterFrom = 128;

Image even_light(float value) {
  Image image(kBalanceSide, kBalanceSide, 3);
  for (float& v : image.data()) v = value;
  return image;
}

// Light of mean 1 that one pixel of `rarity` meets, `brighter` times as much on the right.
Image rare_light(float rarity, float brighter, uint64_t seed) {
  test::Random random(seed);
  Image image(kBalanceSide, kBalanceSide, 3);
  for (int y = 0; y < kBalanceSide; ++y)
    for (int x = 0; x < kBalanceSide; ++x) {
      const float mean = x < kBrighterFrom ? 1.0f : brighter;
      image.set_rgb(x, y, Rgb{random.next() * rarity < 1 ? rarity * mean : 0.0f});
    }
  return image;
}

// Of samples whose own noise is not known.
Recovered balanced_by(Image guess, const Image& samples, TaskPool& pool) {
  Image unknown(samples.width(), samples.height(), 1);
  std::ranges::fill(unknown.data(), std::numeric_limits<float>::infinity());
  return balanced(std::move(guess), samples, unknown, pool);
}

Image every_second(const Image& image) {
  Image out(image.width() / 2, image.height() / 2, 3);
  for (int y = 0; y < out.height(); ++y)
    for (int x = 0; x < out.width(); ++x) out.set_rgb(x, y, image.rgb(2 * x, 2 * y));
  return out;
}

double light_of(const Image& image, int x0, int y0, int side, int step) {
  double sum = 0;
  for (int y = y0; y < y0 + side; y += step)
    for (int x = x0; x < x0 + side; x += step)
      sum += static_cast<double>(luminance(image.rgb(x, y)));
  return sum;
}

TEST(Balance, WhatAGuessLeavesOutComesBack) {
  TaskPool pool(2);
  const Image samples = rare_light(4, 1, 1);
  const Image dark = balanced_by(even_light(0.25f), samples, pool).picture;
  EXPECT_NEAR(light_of(dark, 0, 0, kBalanceSide, 1) / light_of(samples, 0, 0, kBalanceSide, 1), 1,
              0.005);
  EXPECT_LT(relmse(dark, even_light(1)), 0.02) << "and it is no noisier";
}

TEST(Balance, LightFromNowhereGoes) {
  TaskPool pool(2);
  const Image samples = rare_light(4, 1, 2);
  Image guess = even_light(1);
  for (int y = 40; y < 48; ++y)
    for (int x = 40; x < 48; ++x) guess.set_rgb(x, y, Rgb{1600});
  const Recovered r = balanced_by(guess, samples, pool);
  EXPECT_GE(r.held, 64u);
  EXPECT_LE(r.held, 80u) << "and some at the edge whose samples are all black";
  float most = 0;
  for (const float v : r.picture.data()) most = std::max(most, v);
  EXPECT_LE(most, 4);
  EXPECT_NEAR(light_of(r.picture, 0, 0, kBalanceSide, 1), light_of(samples, 0, 0, kBalanceSide, 1),
              0.02 * kBalanceSide * kBalanceSide);
}

TEST(Balance, EachSquareHasTheLightOfItsSamples) {
  TaskPool pool(2);
  for (const int step : {1, 2}) {
    const Image samples = rare_light(4, 3, 3);
    const Image picture =
        balanced_by(even_light(0.7f), step == 1 ? samples : every_second(samples), pool).picture;
    for (int y = 0; y < kBalanceSide; y += kSquarePx)
      for (int x = 0; x < kBalanceSide; x += kSquarePx) {
        const double seen = light_of(samples, x, y, kSquarePx, step);
        EXPECT_NEAR(light_of(picture, x, y, kSquarePx, step) / seen, 1, 0.12)
            << x << ", " << y << ", step " << step;
      }
  }
}

TEST(Balance, LightIsMissedWhereItIsBright) {
  TaskPool pool(2);
  const Image rare = rare_light(4, 1, 6);
  Image samples = rare, guess = rare, truth = rare;
  for (int y = 0; y < kBalanceSide; ++y)
    for (int x = 0; x < kBalanceSide; ++x) {
      const bool is_bright = (x / 8 + y / 8) % 2 == 0;
      const float is = is_bright ? 20 : 1;
      samples.set_rgb(x, y, rare.rgb(x, y) * is);
      truth.set_rgb(x, y, Rgb{is});
      guess.set_rgb(x, y, Rgb{is_bright ? 10.0f : 1.0f});
    }
  const Image picture = balanced_by(guess, samples, pool).picture;
  EXPECT_GT(relmse(guess, truth), 0.1);
  EXPECT_LT(relmse(picture, truth), 0.01) << "what is dark in the same squares stays as it is";
}

TEST(Balance, EachChannelStaysWithinTheSamplesAround) {
  TaskPool pool(2);
  test::Random random(4);
  Image samples(kBalanceSide, kBalanceSide, 3), guess = samples;
  for (float& v : samples.data()) v = random.next();
  for (float& v : guess.data()) v = 3 * random.next();
  const Image picture = balanced_by(guess, samples, pool).picture;
  for (int y = 0; y < kBalanceSide; ++y)
    for (int x = 0; x < kBalanceSide; ++x)
      for (int c = 0; c < 3; ++c) {
        float least = 1, most = 0;
        for (int j = std::max(0, y - 3); j < std::min(kBalanceSide, y + 4); ++j)
          for (int i = std::max(0, x - 3); i < std::min(kBalanceSide, x + 4); ++i) {
            least = std::min(least, samples.at(i, j, c));
            most = std::max(most, samples.at(i, j, c));
          }
        ASSERT_GE(picture.at(x, y, c), least) << x << ", " << y;
        ASSERT_LE(picture.at(x, y, c), most) << x << ", " << y;
      }
}

TEST(Balance, AGoodGuessKeepsItsShape) {
  TaskPool pool(2);
  // Noise alone moves nothing by more than it is.
  const Recovered r = balanced_by(even_light(1), rare_light(2, 1, 5), pool);
  EXPECT_LT(relmse(r.picture, even_light(1)), 0.002);
  EXPECT_EQ(r.held, 0u);
}

TEST(Balance, OneFireflyDoesNotLightThePicture) {
  TaskPool pool(2);
  Image samples = even_light(1);
  samples.set_rgb(50, 50, Rgb{1e6f});
  const Image picture = balanced_by(even_light(1), samples, pool).picture;
  EXPECT_LT(relmse(picture, even_light(1)), 1e-3);
}

TEST(Balance, SquaresDoNotShow) {
  TaskPool pool(2);
  // The samples' light has a step that the guess does not know.
  const Image picture = balanced_by(even_light(1), rare_light(2, 3, 6), pool).picture;
  for (int y = 0; y < kBalanceSide; ++y)
    for (int x = 1; x < kBalanceSide; ++x)
      EXPECT_LT(std::abs(picture.at(x, y, 0) - picture.at(x - 1, y, 0)), 0.3f) << x << ", " << y;
}

TEST(Balance, DarknessBesideManyLitPixelsIsNoAccident) {
  TaskPool pool(2);
  for (const float rarity : {1.2f, 200.0f}) {
    Image samples = rare_light(rarity, 1, 8);
    for (int y = 0; y < kBalanceSide; ++y)
      for (int x = 100; x < kBalanceSide; ++x) samples.set_rgb(x, y, Rgb{});
    const Image picture = balanced_by(even_light(0.5f), samples, pool).picture;
    double most = 0;  // beyond the reach of the lit samples' range, within that of their mean
    for (int y = 0; y < kBalanceSide; ++y)
      for (int x = 104; x < 108; ++x)
        most = std::max(most, static_cast<double>(picture.at(x, y, 0)));
    if (rarity < 10)
      EXPECT_LT(most, 0.04) << "under a tenth of the guess";
    else
      EXPECT_GT(most, 0.1) << "where light is rare it may be here too";
  }
}

TEST(Balance, SquaresWithoutARareSampleAreNotHeldToTheDimOnes) {
  TaskPool pool(2);
  // All samples meet a tenth of the light, one of 100 the rest: most 7 x 7 pixels have none.
  Image samples = rare_light(100, 1, 9);
  for (float& v : samples.data()) v = 0.1f + 0.9f * v;
  const Recovered r = balanced_by(even_light(1), samples, pool);
  EXPECT_LT(r.held, 370u) << "a hundredth";
  EXPECT_LT(relmse(r.picture, even_light(1)), 0.02);
}

TEST(Balance, IsTheSameForAnyNumberOfThreads) {
  TaskPool one(1), three(3);
  const Image samples = rare_light(4, 2, 7);
  EXPECT_EQ(relmse(balanced_by(even_light(0.5f), samples, one).picture,
                   balanced_by(even_light(0.5f), samples, three).picture),
            0);
}

TEST(Balance, BlackStaysBlack) {
  TaskPool pool(1);
  const Recovered r = balanced_by(even_light(0), every_second(even_light(0)), pool);
  for (const float v : r.picture.data()) ASSERT_EQ(v, 0);
}

}  // namespace
}  // namespace qray
