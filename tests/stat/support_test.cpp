// The tests' own statistics: known quantiles, and that a test with no fault passes as often as
// told.
#include <gtest/gtest.h>

#include <vector>

#include "tests/support/chi2.h"
#include "tests/support/stats.h"

namespace qray {
namespace {

TEST(Support, TailsAreTheTabulatedOnes) {
  EXPECT_NEAR(test::chi2_tail(3.841459, 1), 0.05, 1e-6);
  EXPECT_NEAR(test::chi2_tail(18.307038, 10), 0.05, 1e-6);
  EXPECT_NEAR(test::chi2_tail(149.449253, 100), 0.001, 1e-6);
  EXPECT_NEAR(test::chi2_tail(2.558212, 10), 0.99, 1e-6);
  EXPECT_EQ(test::chi2_tail(0, 5), 1);
  EXPECT_NEAR(test::normal_tail(1.959964), 0.05, 1e-6);
  EXPECT_NEAR(test::normal_tail(-3.290527), 0.001, 1e-6);
}

TEST(Support, MomentsAndZ) {
  test::Moments m, shifted;
  for (const double x : {2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0}) {
    m.add(x);
    shifted.add(x + 1);
  }
  EXPECT_DOUBLE_EQ(m.mean(), 5);
  EXPECT_NEAR(m.variance(), 32.0 / 7, 1e-12);
  EXPECT_NEAR(m.standard_error(), std::sqrt(4.0 / 7), 1e-12);
  EXPECT_NEAR(test::z_test(m, 4).z, 1 / std::sqrt(4.0 / 7), 1e-12);
  EXPECT_NEAR(test::z_test(m, shifted).z, -1 / std::sqrt(8.0 / 7), 1e-12);
  test::Moments constant;
  constant.add(1);
  constant.add(1);
  EXPECT_EQ(test::z_test(constant, 1).p_value, 1);
  EXPECT_EQ(test::z_test(constant, 2).p_value, 0);
}

// P values of a right sampler are uniform: about a tenth of them lie under a tenth.
TEST(Support, Chi2KeepsItsLevel) {
  int under_tenth = 0;
  constexpr int kRuns = 400;
  for (int run = 0; run < kRuns; ++run) {
    test::Chi2Options options;
    options.samples = 5000;
    options.seed = 1000 + static_cast<uint64_t>(run);
    options.bins_u = options.bins_v = 8;
    const test::Chi2 chi2 = test::chi2_square(
        [](test::Random& r) -> std::optional<Vec2> {
          const Vec2 u = r.next_2d();
          if (r.next() < 0.25f) return std::nullopt;
          return Vec2{std::sqrt(u.x), u.y};
        },
        [](Vec2 p) { return 0.75 * 2 * p.x; }, options);
    under_tenth += chi2.p_value < 0.1 ? 1 : 0;
  }
  EXPECT_NEAR(under_tenth, 40, 4 * 6);  // sd = sqrt(400 .1 .9) = 6
}

TEST(Support, Chi2NoticesSmallFaults) {
  const auto uniform = [](test::Random& r) -> std::optional<Vec2> { return r.next_2d(); };
  EXPECT_LT(test::chi2_square(uniform, [](Vec2 p) { return 0.98 + 0.04 * p.x; },
                              {.samples = 1'000'000, .bins_u = 8, .bins_v = 8})
                .p_value,
            1e-6);
  // Samples where the density is zero, and a density of more than one.
  EXPECT_EQ(test::chi2_square(uniform, [](Vec2 p) { return p.x < 0.5f ? 2.0 : 0.0; }).p_value, 0);
  EXPECT_EQ(test::chi2_square(uniform, [](Vec2) { return 1.01; }).p_value, 0);
}

}  // namespace
}  // namespace qray
