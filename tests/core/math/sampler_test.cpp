#include "core/math/sampler.h"

#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "tests/support/chi2.h"
#include "tests/support/stats.h"

namespace qray {
namespace {

// The point of one pair of dimensions: the first two come one by one, as a camera takes them, the
// others by four, as vertices do.
Vec2 point(uint64_t seed, uint32_t x, uint32_t y, uint32_t sample, int pair) {
  Sampler sampler(seed);
  sampler.start(x, y, sample);
  for (int i = 0; i < std::min(pair, 2); ++i) sampler.next_2d();
  if (pair < 2) return sampler.next_2d();
  for (int i = 2; i + 4 <= pair; i += 4) sampler.next_pairs();
  const Sampler::Pairs four = sampler.next_pairs();
  const Vec2 pairs[] = {four.a, four.b, four.c, four.d};
  return pairs[(pair - 2) % 4];
}

TEST(Sampler, EveryPairIsANet) {
  // (0, 2)-sequence in base 2: of each aligned block of 2^k samples, every elementary interval of
  // area 2^-k, of whatever shape, holds exactly one.
  for (const int pair : {0, 1, 2, 3, 4, 5, 62})
    for (const uint32_t pixel : {0u, 1u, 500u})
      for (int k = 0; k <= 9; ++k)
        for (const uint32_t block : {0u, 1u, 5u})
          for (int log_x = 0; log_x <= k; ++log_x) {
            const uint32_t count = 1u << k, nx = 1u << log_x, ny = 1u << (k - log_x);
            std::vector<int> hits(count, 0);
            for (uint32_t i = 0; i < count; ++i) {
              const Vec2 u = point(9, pixel, 3 * pixel, block * count + i, pair);
              ASSERT_TRUE(u.x >= 0 && u.x < 1 && u.y >= 0 && u.y < 1);
              ++hits[static_cast<uint32_t>(u.x * static_cast<float>(nx)) * ny +
                     static_cast<uint32_t>(u.y * static_cast<float>(ny))];
            }
            ASSERT_EQ(hits, std::vector<int>(count, 1))
                << "pair " << pair << " block " << block << " of " << count << ", " << nx << " x "
                << ny;
          }
}

TEST(Sampler, DependsOnSeedPixelSampleAndDimensionAlone) {
  Sampler a(5), b(5);
  a.start(1, 2, 3);
  a.next_2d();
  a.next_pairs();
  a.start(7, 8, 9);
  b.start(7, 8, 9);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(a.next_2d(), b.next_2d());
  const Vec2 u = point(5, 7, 8, 9, 4);
  EXPECT_EQ(point(5, 7, 8, 9, 4), u);
  EXPECT_NE(point(6, 7, 8, 9, 4), u);
  EXPECT_NE(point(5, 8, 8, 9, 4), u);
  EXPECT_NE(point(5, 8, 7, 9, 4), point(5, 7, 8, 9, 4));
  EXPECT_NE(point(5, 7, 8, 10, 4), u);
  EXPECT_NE(point(5, 7, 8, 9, 5), u);
}

// Two numbers that should be independent and uniform, over pixels.
struct Relation {
  const char* name;
  std::function<Vec2(uint32_t x, uint32_t y)> numbers;
};

TEST(Sampler, PixelsDimensionsAndSamplesAreIndependent) {
  const Relation relations[] = {
      {"x and y of a sample", [](uint32_t x, uint32_t y) { return point(1, x, y, 0, 0); }},
      {"x and y of a later sample", [](uint32_t x, uint32_t y) { return point(1, x, y, 77, 3); }},
      {"two pairs",
       [](uint32_t x, uint32_t y) {
         return Vec2{point(1, x, y, 0, 0).x, point(1, x, y, 0, 1).x};
       }},
      {"two pairs of one vertex",
       [](uint32_t x, uint32_t y) {
         return Vec2{point(1, x, y, 3, 2).x, point(1, x, y, 3, 3).x};
       }},
      {"two pairs of one vertex, crossed",
       [](uint32_t x, uint32_t y) {
         return Vec2{point(1, x, y, 3, 4).x, point(1, x, y, 3, 5).y};
       }},
      {"two vertices",
       [](uint32_t x, uint32_t y) {
         return Vec2{point(1, x, y, 0, 2).y, point(1, x, y, 0, 6).y};
       }},
      {"neighbours in a row",
       [](uint32_t x, uint32_t y) {
         return Vec2{point(1, 2 * x, y, 0, 0).x, point(1, 2 * x + 1, y, 0, 0).x};
       }},
      {"neighbours in a column",
       [](uint32_t x, uint32_t y) {
         return Vec2{point(1, x, 2 * y, 0, 0).y, point(1, x, 2 * y + 1, 0, 0).y};
       }},
      {"two seeds",
       [](uint32_t x, uint32_t y) {
         return Vec2{point(1, x, y, 0, 0).x, point(2, x, y, 0, 0).x};
       }},
      {"far samples", [](uint32_t x, uint32_t y) {
         return Vec2{point(1, x, y, 0, 0).x, point(1, x, y, 1u << 20, 0).y};
       }}};
  for (const Relation& relation : relations) {
    test::Chi2Options options;
    options.samples = 1 << 16;
    options.bins_u = options.bins_v = 32;
    uint32_t pixel = 0;
    const test::Chi2 chi2 = test::chi2_square(
        [&](test::Random&) -> std::optional<Vec2> {
          const uint32_t p = pixel++;
          return relation.numbers(p % 256, p / 256);
        },
        [](Vec2) { return 1.0; }, options);
    EXPECT_GT(chi2.p_value, test::significance(static_cast<int>(std::size(relations))))
        << relation.name << "\n"
        << chi2.table;
  }
}

TEST(Sampler, SamplesOfDifferentPairsFillTheSquareAlike) {
  // Padded pairs are shuffled against each other: their x against x is no net, but uniform.
  test::Chi2Options options;
  options.samples = 1 << 16;
  options.bins_u = options.bins_v = 16;
  uint32_t i = 0;
  const test::Chi2 chi2 = test::chi2_square(
      [&](test::Random&) -> std::optional<Vec2> {
        const uint32_t sample = i++;
        return Vec2{point(4, 10, 20, sample, 2).x, point(4, 10, 20, sample, 3).x};
      },
      [](Vec2) { return 1.0; }, options);
  EXPECT_GT(chi2.p_value, test::significance(1)) << chi2.table;
}

TEST(Sampler, StratifiedMeansBeatRandomOnes) {
  // The mean of a smooth function over 256 samples: its error falls well below the 1/16 sd of
  // independent samples.
  test::Moments errors;
  for (uint32_t pixel = 0; pixel < 200; ++pixel) {
    double sum = 0;
    for (uint32_t i = 0; i < 256; ++i) {
      const Vec2 u = point(3, pixel, 0, i, 1);
      sum += std::exp(u.x) * u.y;
    }
    errors.add(sum / 256 - (std::numbers::e - 1) / 2);
  }
  const double sd_of_one =
      std::sqrt((std::exp(2.0) - 1) / 6 - std::pow((std::numbers::e - 1) / 2, 2));
  EXPECT_LT(std::sqrt(errors.variance()), sd_of_one / 16 / 10);
  EXPECT_LT(std::abs(test::z_test(errors, 0).z), 4);
}

}  // namespace
}  // namespace qray
