#include "core/live/walls.h"

#include <gtest/gtest.h>

#include "tests/support/render.h"

namespace qray {
namespace {

// Cornell's box is 0.556 m wide and stands at the origin; its camera looks in from z = -0.8.
constexpr Vec3 kInside{0.278f, 0.45f, 0.28f};

class Walls : public ::testing::Test {
 protected:
  Vec3 walk(Vec3 from, Vec3 to) const { return stop_before_walls(*scene_, from, to); }
  float kept() const { return 0.01f * scene_->bounds.radius(); }
  std::shared_ptr<const PreparedScene> scene_ = test::included_scene("cornell-box");
};

TEST_F(Walls, AWayThatIsFreeIsWalked) {
  const Vec3 to = kInside + Vec3{0.05f, 0.02f, -0.1f};
  EXPECT_EQ(walk(kInside, to), to);
  EXPECT_EQ(walk(kInside, kInside), kInside);
}

TEST_F(Walls, AWallStopsShortOfItself) {
  const Vec3 stop = walk(kInside, kInside + Vec3{0.4f, 0, 0});
  EXPECT_GT(stop.x, 0.5f);
  EXPECT_LT(stop.x, 0.56f - 0.5f * kept());
  EXPECT_NEAR(stop.y, kInside.y, 2e-3f);  // the wall leans
  EXPECT_NEAR(stop.z, kInside.z, 2e-3f);
}

TEST_F(Walls, AlongAWallOneSlides) {
  const Vec3 stop = walk(kInside, kInside + Vec3{1, 0.03f, 0});
  EXPECT_LT(stop.x, 0.56f);
  EXPECT_GT(stop.y, kInside.y + 0.01f);
}

TEST_F(Walls, NoNumberOfStepsGetsThrough) {
  for (const Vec3 step : {Vec3{0.02f, 0, 0}, Vec3{0, 0.02f, 0}, Vec3{0.02f, 0.015f, 0.02f}}) {
    Vec3 at = kInside;
    for (int i = 0; i < 200; ++i) at = walk(at, at + step);
    EXPECT_LT(at.x, 0.56f);
    EXPECT_LT(at.y, 0.56f);
    EXPECT_LT(at.z, 0.56f);
  }
}

}  // namespace
}  // namespace qray
