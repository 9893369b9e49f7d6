#include "core/guide/dahm_keller.h"

#include <gtest/gtest.h>

#include <numeric>

#include "core/math/warp.h"
#include "tests/core/guide/one_point.h"
#include "tests/support/random.h"

namespace qray {
namespace {

using test::kNormal, test::kPoint, test::unit_cube;

// Events at one state: rays that see `emitted` and land where the surface has `albedo` and the same
// state, as in a closed room of one colour.
void teach(DahmKellerGuide& guide, int events, float emitted, float albedo) {
  test::Random random(7);
  const std::unique_ptr<GuideDelta> delta = guide.make_delta();
  for (int i = 0; i < events; ++i) {
    GuideVertex v[2];
    v[0].at = guide.find(kPoint, kNormal);
    v[1].at = v[0].at;
    v[0].wi = v[0].at.frame.to_world(square_to_uniform_hemisphere(random.next_2d()));
    v[0].pdf_w = kUniformHemispherePdfW;
    v[0].guidable = v[0].transition.lands = true;
    v[0].transition.emitted = emitted;
    v[1].transition.albedo = albedo;
    guide.record(v, *delta);
    guide.update(*delta);
  }
  guide.end_pass();
}

// The expected update has the fixed point of light transport: e / (1 - albedo).
TEST(DahmKeller, ValuesApproachTheLightOfAClosedRoom) {
  DahmKellerGuide guide(unit_cube());
  teach(guide, 400'000, 1, 0.5f);
  const DahmKellerGuide::Values* q = guide.values(guide.find(kPoint, kNormal).key);
  ASSERT_NE(q, nullptr);
  for (float value : *q) EXPECT_NEAR(value, 2, 0.1);
}

TEST(DahmKeller, BlackSurfacesKeepWhatIsEmitted) {
  DahmKellerGuide guide(unit_cube());
  teach(guide, 20'000, 3, 0);
  for (float value : *guide.values(guide.find(kPoint, kNormal).key)) EXPECT_NEAR(value, 3, 1e-3);
}

TEST(DahmKeller, SavedLoadedAndSavedAgainItIsTheSameFile) {
  DahmKellerGuide guide(unit_cube()), other(unit_cube());
  teach(guide, 20'000, 1, 0.5f);
  const std::vector<TableSection> saved = guide.save();
  ASSERT_TRUE(other.load(saved).ok());
  const std::vector<TableSection> again = other.save();
  ASSERT_EQ(again.size(), saved.size());
  for (size_t i = 0; i < saved.size(); ++i) EXPECT_EQ(again[i].bytes, saved[i].bytes);
  const GuidePoint point = guide.find(kPoint, kNormal);
  const Vec3 wi = normalize(Vec3{0.3f, 0.2f, 0.8f});
  EXPECT_EQ(other.pdf_w(other.find(kPoint, kNormal), wi), guide.pdf_w(point, wi));
}

}  // namespace
}  // namespace qray
