#include "core/recover/surroundings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "tests/support/random.h"

namespace qray {
namespace {

constexpr int kAroundSide = 96;  // pixels

// Light of mean 1 that one pixel of `rarity` meets, on the left of `dark_from`; known to be noisy,
// or not.
struct RareLight {
  Image samples{kAroundSide, kAroundSide, 3}, own_error{kAroundSide, kAroundSide, 1};

  RareLight(float rarity, int dark_from, bool is_known) {
    test::Random random(5);
    for (int y = 0; y < kAroundSide; ++y)
      for (int x = 0; x < kAroundSide; ++x) {
        const float light = x < dark_from && random.next() * rarity < 1 ? rarity : 0.0f;
        samples.set_rgb(x, y, Rgb{light});
        own_error.at(x, y, 0) = is_known ? light : std::numeric_limits<float>::infinity();
      }
  }
};

TEST(Surroundings, RareLightComesOfBrightHits) {
  TaskPool pool(2);
  for (const float rarity : {10.0f, 50.0f})
    for (const bool is_known : {false, true}) {
      const RareLight light(rarity, kAroundSide, is_known);
      const Surroundings around(light.samples, light.own_error, pool);
      for (int y = 0; y < kAroundSide; y += 5)
        for (int x = 0; x < kAroundSide; x += 5)
          EXPECT_NEAR(around.light_of_a_hit(x, y).g / rarity, 1, is_known ? 0.01 : 0.5)
              << x << ", " << y;
    }
}

TEST(Surroundings, EvenLightHasNoHits) {
  TaskPool pool(1);
  Image even(kAroundSide, kAroundSide, 3), unknown(kAroundSide, kAroundSide, 1);
  std::ranges::fill(even.data(), 2.0f);
  std::ranges::fill(unknown.data(), std::numeric_limits<float>::infinity());
  EXPECT_EQ(Surroundings(even, unknown, pool).light_of_a_hit(50, 50), Rgb{});
}

TEST(Surroundings, WhereAllIsBlackHitsAreAsElsewhereIfTheyAreRare) {
  TaskPool pool(2);
  const RareLight common(2, 40, true), rare(1000, 40, true);
  EXPECT_LT(Surroundings(common.samples, common.own_error, pool).light_of_a_hit(80, 50).g, 1e-6f);
  EXPECT_NEAR(Surroundings(rare.samples, rare.own_error, pool).light_of_a_hit(80, 50).g, 1000, 1);
}

TEST(Surroundings, APictureMayBeOfOnePixel) {
  TaskPool pool(1);
  Image samples(1, 1, 3), unknown(1, 1, 1);
  samples.set_rgb(0, 0, Rgb{3});
  unknown.at(0, 0, 0) = std::numeric_limits<float>::infinity();
  EXPECT_EQ(Surroundings(samples, unknown, pool).light_of_a_hit(0, 0), Rgb{});
}

}  // namespace
}  // namespace qray
