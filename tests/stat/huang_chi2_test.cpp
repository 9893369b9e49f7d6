// The thesis' Algorithm 1 draws directions with the density that core/guide/huang.h derives.
#include <gtest/gtest.h>

#include "core/guide/huang.h"
#include "core/math/warp.h"
#include "tests/support/chi2.h"
#include "tests/support/random_tables.h"
#include "tests/support/stats.h"

namespace qray {
namespace {

const Bounds3 kBounds{{0, 0, 0}, {1, 1, 1}};
const Vec3 kHuangPoint{0.4f, 0.3f, 0.6f};

std::vector<Vec3> normals() {
  test::Random random(5);
  std::vector<Vec3> n = {{0, 0, 1}, normalize(Vec3{1, 2, 3})};
  for (int i = 0; i < 2; ++i) n.push_back(square_to_uniform_sphere(random.next_2d()));
  return n;
}

HuangGuide guide_with(HuangGuide::Density density, Vec3 n, const HuangGuide::Values& values) {
  HuangGuide guide(density, kBounds, {});
  guide.set_values(guide.find(kHuangPoint, n).key, values);
  guide.end_pass();
  return guide;
}

TEST(HuangChi2, SamplesFollowTheDensityOverTheSphere) {
  const double level = test::significance(static_cast<int>(normals().size() * 6));
  uint64_t seed = 1;
  for (Vec3 n : normals())
    for (const test::NamedValues& table : test::huang_tables(n, 7)) {
      const HuangGuide guide = guide_with(HuangGuide::Density::kExact, n, table.values);
      const GuidePoint point = guide.find(kHuangPoint, n);
      ASSERT_TRUE(point.state.valid());
      test::Chi2Options options;
      options.seed = seed++;
      options.tolerance = 1e-5;  // the density jumps at the borders of 26 cells
      const test::Chi2 result = test::chi2_sphere(
          [&](test::Random& random) -> std::optional<Vec3> {
            return guide.sample(point, random.next_2d()).wi;
          },
          [&](Vec3 wi) { return guide.pdf_w(point, wi); }, options);
      EXPECT_GT(result.p_value, level) << table.name << "\n" << result.table;
      EXPECT_NEAR(result.integral, 1, 2e-3) << table.name;
    }
}

TEST(HuangChi2, ActionsAreChosenAsOftenAsTheClosedFormSays) {
  // Sharper than bins on the sphere: 26 counts of a million draws against mu_a w_a.
  constexpr int kDraws = 1'000'000;
  const double level = test::significance(static_cast<int>(normals().size() * 6));
  for (Vec3 n : normals()) {
    const HuangGuide::Values shares = hemisphere_shares26(n);
    for (const test::NamedValues& table : test::huang_tables(n, 11)) {
      const HuangGuide guide = guide_with(HuangGuide::Density::kExact, n, table.values);
      const GuidePoint point = guide.find(kHuangPoint, n);
      const HuangGuide::Values weights = HuangGuide::density_weights(table.values, shares);
      std::vector<double> observed(kDirections26), expected(kDirections26);
      test::Random random(13);
      for (int i = 0; i < kDraws; ++i)
        ++observed[static_cast<size_t>(
            nearest_direction26(guide.sample(point, random.next_2d()).wi))];
      double sum = 0;
      for (size_t a = 0; a < kDirections26; ++a) {
        expected[a] = static_cast<double>(shares[a]) * static_cast<double>(weights[a]) * kDraws;
        sum += expected[a] / kDraws;
      }
      EXPECT_NEAR(sum, 1, 1e-5) << table.name;
      const test::Chi2 result = test::chi2_counts(observed, expected);
      EXPECT_GT(result.p_value, level) << table.name << "\n" << result.table;
    }
  }
}

TEST(HuangChi2, SampleTellsTheSameDensityAsPdf) {
  test::Random random(17);
  for (Vec3 n : normals())
    for (const test::NamedValues& table : test::huang_tables(n, 19))
      for (auto density : {HuangGuide::Density::kExact, HuangGuide::Density::kAsPublished}) {
        const HuangGuide guide = guide_with(density, n, table.values);
        const GuidePoint point = guide.find(kHuangPoint, n);
        for (int i = 0; i < 1000; ++i) {
          const GuideSample s = guide.sample(point, random.next_2d());
          EXPECT_NEAR(length(s.wi), 1, 1e-5f);
          // A direction in the horizon's rounding has density 0 in one of the two.
          if (dot(s.wi, point.frame.z) > 1e-4f) {
            EXPECT_EQ(s.pdf_w, guide.pdf_w(point, s.wi));
          }
        }
      }
}

TEST(HuangChi2, NothingLearnedIsTheUniformHemisphere) {
  const HuangGuide guide(HuangGuide::Density::kExact, kBounds, {});
  const GuidePoint point = guide.find(kHuangPoint, normalize(Vec3{1, -2, 0.5f}));
  EXPECT_FALSE(point.state.valid());
  const test::Chi2 result = test::chi2_sphere(
      [&](test::Random& random) -> std::optional<Vec3> {
        return guide.sample(point, random.next_2d()).wi;
      },
      [&](Vec3 wi) { return guide.pdf_w(point, wi); });
  EXPECT_GT(result.p_value, test::significance(1)) << result.table;
}

TEST(HuangChi2, TheBrighteningOfALambertPatchIsAsDerived) {
  // One cell 10x as bright as the rest, straight above: Algorithm 1 without its density gives 3.8x
  // the true reflection (design, section 3), with it the truth.
  const Vec3 n{0, 0, 1};
  HuangGuide::Values values;
  values.fill(1);
  const size_t top = static_cast<size_t>(nearest_direction26(n));
  values[top] = 10;
  const auto reflected = [&](HuangGuide::Density density) {
    const HuangGuide guide = guide_with(density, n, values);
    const GuidePoint point = guide.find(kHuangPoint, n);
    test::Random random(23);
    test::Moments moments;
    for (int i = 0; i < 1'000'000; ++i) {
      const GuideSample s = guide.sample(point, random.next_2d());
      const float radiance = values[static_cast<size_t>(nearest_direction26(s.wi))];
      moments.add(radiance * s.wi.z * kInvPi / s.pdf_w);
    }
    return moments;
  };
  test::Moments truth;
  test::Random random(29);
  for (int i = 0; i < 1'000'000; ++i) {
    const Vec3 wi = square_to_cosine_hemisphere(random.next_2d());
    truth.add(values[static_cast<size_t>(nearest_direction26(wi))]);
  }
  EXPECT_GT(test::z_test(reflected(HuangGuide::Density::kExact), truth).p_value,
            test::significance(1));
  EXPECT_NEAR(reflected(HuangGuide::Density::kAsPublished).mean() / truth.mean(), 3.8, 0.1);
}

}  // namespace
}  // namespace qray
