// What the contracts of a guide's parts promise, of every method.
#include "core/guide/guide.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/guide/open_table.h"
#include "tests/core/guide/taught.h"

namespace qray {
namespace {

using test::setup_of, test::taught;

constexpr size_t kPoints = 20;
constexpr float kRounding = 1e-5f;  // of a direction's cosine

class EveryGuide : public ::testing::TestWithParam<std::string_view> {};

TEST_P(EveryGuide, DensitiesAreAboutThePointsDomain) {
  const std::unique_ptr<Guide> guide = taught(GetParam(), 1, setup_of());
  const std::vector<GuidePoint> points = guide->known_points(kPoints);
  ASSERT_FALSE(points.empty());
  for (const GuidePoint& point : points) {
    // A density that is only pretended is not the one that is drawn with.
    if (guide->unbiased()) {
      EXPECT_NEAR(density_integral(*guide, point), 1, 5e-3) << point.key;
    }
    test::Random random(point.key);
    for (int i = 0; i < 1000; ++i) {
      const Vec3 drawn = guide->sample(point, random.next_2d()).wi;
      EXPECT_TRUE(point.covers(drawn + point.frame.z * kRounding)) << point.key;
      const Vec3 anywhere = square_to_uniform_sphere(random.next_2d());
      if (!point.covers(anywhere)) {
        EXPECT_EQ(guide->pdf_w(point, anywhere), 0) << point.key;
      }
    }
  }
}

TEST_P(EveryGuide, FoundAndKnownPointsHaveOneDomain) {
  const std::unique_ptr<Guide> guide = taught(GetParam(), 1, setup_of());
  const GuideDomain found = guide->find(setup_of().bounds.lo, {0, 1, 0}).domain;
  for (const GuidePoint& point : guide->known_points(kPoints)) EXPECT_EQ(point.domain, found);
  EXPECT_EQ(found, GetParam() == "ppg" ? GuideDomain::kSphere : GuideDomain::kHemisphere);
}

// What needs() does not name may be anything.
TEST_P(EveryGuide, LearnsFromNothingBeyondItsNeeds) {
  const GuideNeeds needs = make_guide(GetParam(), setup_of()).value()->needs();
  const auto spoil = [&](GuideVertex& v) {
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    if (!needs.transition) v.transition = {kNan, kNan, true};
    if (!needs.bsdf) v.bsdf = {kNan, kNan};
  };
  const auto clean = taught(GetParam(), 1, setup_of())->save();
  const auto spoiled = taught(GetParam(), 1, setup_of(), spoil)->save();
  ASSERT_EQ(clean.size(), spoiled.size());
  for (size_t i = 0; i < clean.size(); ++i) EXPECT_EQ(clean[i].bytes, spoiled[i].bytes);
}

INSTANTIATE_TEST_SUITE_P(Methods, EveryGuide, ::testing::ValuesIn(method_names().subspan(1)),
                         [](const auto& info) {
                           std::string name(info.param);
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace qray
