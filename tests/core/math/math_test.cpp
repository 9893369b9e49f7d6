#include <gtest/gtest.h>

#include <set>

#include "core/math/distribution.h"
#include "core/math/frame.h"
#include "core/math/hash.h"
#include "core/math/ray.h"
#include "core/math/warp.h"
#include "tests/support/chi2.h"
#include "tests/support/stats.h"

namespace qray {
namespace {

using test::Random;

constexpr double kLevel = test::significance(10);  // chi-square tests in this file

TEST(Frame, IsOrthonormalAndRightHandedForAnyNormal) {
  Random random(1);
  std::vector<Vec3> normals{{0, 0, 1},       {0, 0, -1},     {1, 0, 0},    {0, -1, 0},
                            {0, 1e-20f, -1}, {1e-4f, 0, -1}, {0, 0, -0.0f}};
  normals.back() = {1, 0, -0.0f};
  for (int i = 0; i < 10'000; ++i) normals.push_back(square_to_uniform_sphere(random.next_2d()));
  for (const Vec3 raw : normals) {
    const Frame f(normalize(raw));
    EXPECT_NEAR(length(f.x), 1, 1e-6);
    EXPECT_NEAR(length(f.y), 1, 1e-6);
    EXPECT_NEAR(dot(f.x, f.y), 0, 1e-6);
    EXPECT_NEAR(dot(f.x, f.z), 0, 1e-6);
    EXPECT_NEAR(dot(f.y, f.z), 0, 1e-6);
    EXPECT_NEAR(dot(cross(f.x, f.y), f.z), 1, 1e-6);
    const Vec3 v{0.3f, -2, 0.7f};
    EXPECT_NEAR(length(f.to_world(f.to_local(v)) - v), 0, 2e-6);
    EXPECT_NEAR(f.to_local(f.z).z, 1, 1e-6);
  }
}

TEST(Warp, DirectionsFollowTheirDensities) {
  const auto test_warp = [](const char* name, Vec3 (*warp)(Vec2), double (*pdf)(Vec3)) {
    const test::Chi2 chi2 = test::chi2_sphere(
        [&](Random& random) -> std::optional<Vec3> { return warp(random.next_2d()); }, pdf);
    EXPECT_GT(chi2.p_value, kLevel) << name << "\n" << chi2.table;
    EXPECT_NEAR(chi2.integral, 1, 1e-3) << name;
  };
  test_warp("cosine", square_to_cosine_hemisphere,
            [](Vec3 w) -> double { return cosine_hemisphere_pdf_w(w.z); });
  test_warp("hemisphere", square_to_uniform_hemisphere,
            [](Vec3 w) -> double { return w.z > 0 ? kUniformHemispherePdfW : 0; });
  test_warp("sphere", square_to_uniform_sphere, [](Vec3) -> double { return kUniformSpherePdfW; });
}

TEST(Warp, DiskIsUniform) {
  // By radius squared and angle, a uniform disk is a uniform square.
  const test::Chi2 chi2 = test::chi2_square(
      [](Random& random) -> std::optional<Vec2> {
        const Vec2 d = square_to_disk(random.next_2d());
        const float turn = std::atan2(d.y, d.x) / (2 * kPi);
        return Vec2{d.x * d.x + d.y * d.y, turn < 0 ? turn + 1 : turn};
      },
      [](Vec2) { return 1.0; });
  EXPECT_GT(chi2.p_value, kLevel) << chi2.table;
  EXPECT_EQ(square_to_disk({0.5f, 0.5f}), (Vec2{0, 0}));
  for (const Vec2 corner : {Vec2{0, 0}, Vec2{1, 0}, Vec2{0, 1}, Vec2{1, 1}}) {
    const Vec2 d = square_to_disk(corner);
    EXPECT_NEAR(std::hypot(d.x, d.y), 1, 1e-6);
  }
}

TEST(Warp, TriangleIsUniform) {
  // v = 1 - sqrt(1 - b1) ... of a uniform triangle: (1 - b1)^2 and b2 / (1 - b1) are uniform.
  const test::Chi2 chi2 = test::chi2_square(
      [](Random& random) -> std::optional<Vec2> {
        const Vec2 b = square_to_triangle(random.next_2d());
        EXPECT_TRUE(b.x >= 0 && b.y >= 0 && b.x + b.y <= 1);
        return Vec2{sqr(1 - b.x), b.y / (1 - b.x)};
      },
      [](Vec2) { return 1.0; });
  EXPECT_GT(chi2.p_value, kLevel) << chi2.table;
}

TEST(AliasTable, PicksByWeight) {
  Random random(3);
  std::vector<float> weights(200);
  double sum = 0;
  for (size_t i = 0; i < weights.size(); ++i) {
    weights[i] = i % 7 == 0 ? 0.0f : std::pow(random.next(), 4.0f);
    sum += weights[i];
  }
  const AliasTable table(weights);
  constexpr int kPicks = 500'000;
  std::vector<double> observed(weights.size(), 0.0), expected;
  for (const float w : weights) expected.push_back(w / sum * kPicks);
  for (int i = 0; i < kPicks; ++i) {
    const AliasTable::Pick pick = table.sample(random.next());
    ++observed[pick.index];
    ASSERT_EQ(pick.probability, table.probability(pick.index));
    ASSERT_NEAR(pick.probability, weights[pick.index] / sum, 1e-6);
    ASSERT_GT(pick.probability, 0);
  }
  const test::Chi2 chi2 = test::chi2_counts(observed, expected);
  EXPECT_GT(chi2.p_value, kLevel) << chi2.table;
}

TEST(AliasTable, OddWeights) {
  const std::vector<float> zeros(3, 0.0f), one{5.0f}, last{0, 0, 1e-30f};
  EXPECT_NEAR(AliasTable(zeros).sample(0.5f).probability, 1.0 / 3, 1e-6);
  EXPECT_EQ(AliasTable(one).sample(0x1.fffffep-1f).index, 0u);
  Random random(1);
  const AliasTable table(last);
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(table.sample(random.next()).index, 2u);
}

CdfPick pick(std::span<const float> cdf, size_t parts, float u) {
  std::vector<uint32_t> guide(parts + 1);
  fill_guide(cdf, guide);
  return pick_by_cdf(cdf, guide, u);
}

TEST(Cdf, PicksByWeightAndPlacesEvenly) {
  const std::vector<float> weights{0, 1, 0, 3, 0}, zeros(4, 0.0f);
  for (const size_t parts : {1, 2, 8, 64}) {
    std::vector<float> cdf(6);
    EXPECT_EQ(fill_cdf(weights, cdf), 4);
    for (const float u : {0.0f, 0.1f, 0.2f}) {
      EXPECT_EQ(pick(cdf, parts, u).index, 1);
      EXPECT_FLOAT_EQ(pick(cdf, parts, u).offset, u * 4);
    }
    EXPECT_EQ(pick(cdf, parts, 0.25f).index, 3);
    EXPECT_FLOAT_EQ(pick(cdf, parts, 0.625f).offset, 0.5f);
    EXPECT_EQ(pick(cdf, parts, kOneMinusEpsilon).index, 3);
    EXPECT_LT(pick(cdf, parts, kOneMinusEpsilon).offset, 1);
    cdf.resize(5);
    EXPECT_EQ(fill_cdf(zeros, cdf), 0);
    EXPECT_EQ(pick(cdf, parts, 0.6f).index, 2);
  }
}

TEST(Cdf, AGuideOnlyShortensTheSearch) {
  Random random(7);
  std::vector<float> weights(1000), cdf(1001);
  for (float& w : weights) w = random.next() < 0.3f ? 0 : std::pow(random.next(), 20.0f);
  fill_cdf(weights, cdf);
  for (const size_t parts : {1, 16, 64, 1024}) {
    std::vector<uint32_t> guide(parts + 1);
    fill_guide(cdf, guide);
    for (int i = 0; i < 20'000; ++i) {
      // Every other one where a part or an interval begins.
      const float u = i % 2 ? random.next()
                            : std::min(cdf[static_cast<size_t>(i / 2 % 1000)], kOneMinusEpsilon);
      const auto above = std::upper_bound(cdf.begin(), cdf.end(), u);
      ASSERT_EQ(pick_by_cdf(cdf, guide, u).index, above - cdf.begin() - 1) << u;
    }
  }
}

TEST(Warp, AnglesAreTheLibrarys) {
  Random random(8);
  for (int i = 0; i < 10'000; ++i) {
    const float x = random.next() - 0.5f, y = random.next() - 0.5f;
    ASSERT_NEAR(angle_of(y, x), std::atan2(y, x), 4e-7) << y << ", " << x;
  }
  for (const auto& [y, x] : {std::pair{0.0f, 1.0f},
                             {1.0f, 0.0f},
                             {-1.0f, 0.0f},
                             {0.0f, -1.0f},
                             {1e-30f, 1.0f},
                             {0.0f, 0.0f}})
    EXPECT_NEAR(angle_of(y, x), std::atan2(y, x), 4e-7) << y << ", " << x;
}

TEST(Warp, LinearFollowsItsDensity) {
  for (const auto& [a, b] : {std::pair{1.0f, 3.0f}, {2.0f, 0.0f}, {0.0f, 1.0f}, {1.0f, 1.0f}}) {
    for (const float u : {0.0f, 0.3f, 0.5f, 0.9f, kOneMinusEpsilon}) {
      const float x = sample_linear(u, a, b);
      EXPECT_NEAR((a * x + (b - a) * x * x / 2) / ((a + b) / 2), u, 1e-6) << a << " " << b;
      EXPECT_LT(x, 1);
    }
  }
}

TEST(Hash, SplitMixVectors) {
  // The generator's first outputs from state 1234567.
  constexpr uint64_t kStep = 0x9e3779b97f4a7c15ull;
  EXPECT_EQ(mix64(1234567), 6457827717110365317ull);
  EXPECT_EQ(mix64(1234567 + kStep), 3203168211198807973ull);
  EXPECT_EQ(mix64(1234567 + 2 * kStep), 9817491932198370423ull);
  EXPECT_NE(hash_combine(1, 2), hash_combine(2, 1));
  EXPECT_EQ(to_unit_float(0xffffffffu), 0x1.fffffep-1f);
  EXPECT_EQ(to_unit_float(0x80000000u), 0.5f);
}

TEST(Bounds3, GrowsByPoints) {
  Bounds3 box;
  EXPECT_TRUE(box.empty());
  box.add({1, 2, 3});
  EXPECT_FALSE(box.empty());
  box.add({-1, 4, 3});
  EXPECT_EQ(box.lo, (Vec3{-1, 2, 3}));
  EXPECT_EQ(box.center(), (Vec3{0, 3, 3}));
  EXPECT_FLOAT_EQ(box.radius(), std::sqrt(2.0f));
}

}  // namespace
}  // namespace qray
