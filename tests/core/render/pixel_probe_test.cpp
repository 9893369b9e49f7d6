#include "core/render/pixel_probe.h"

#include <gtest/gtest.h>

#include "core/guide/huang.h"
#include "tests/core/render/wall.h"

namespace qray {
namespace {

using test::Wall;

TEST(PixelProbe, FindsTheSurfaceAndItsState) {
  const Wall wall;
  HuangGuide guide(HuangGuide::Density::kExact, wall.scene->bounds, {});
  const auto probe = [&](int x, int y) {
    return probe_pixel(*wall.scene, wall.settings, &guide, x, y).value();
  };
  const std::optional<PixelProbe> before = probe(8, 15);
  ASSERT_TRUE(before && before->state);
  EXPECT_NEAR(before->seen.point.p.z, 0, 1e-5);
  EXPECT_LT(before->seen.point.p.x, 0);
  EXPECT_FALSE(before->state->known);
  EXPECT_TRUE(before->state->directions.empty());
  HuangGuide::Values values{};
  values[static_cast<size_t>(nearest_direction26({0, 0, 1}))] = 1;
  guide.set_values(before->state->at.key, values);
  guide.end_pass();
  const std::optional<PixelProbe> after = probe(8, 15);
  ASSERT_TRUE(after && after->state && after->state->known);
  EXPECT_GT(after->state->gain, 1);
  EXPECT_GT(after->state->summary.size_m, 0);
  // The nine that look away from the wall, and those along it: none into it.
  EXPECT_EQ(after->state->directions.size(), 17u);
  for (const ProbedDirection& d : after->state->directions) {
    EXPECT_GE(d.cell.wi.z, 0);
    ASSERT_TRUE(d.rod_end.has_value());  // 5 % of the scene: not as far as the camera
    const Vec3 wi = d.cell.wi;
    EXPECT_TRUE(wi.y != 0 || wi.x <= 0 || d.rod_end->x > 8.5f);
    EXPECT_TRUE(wi.x != 0 || wi.y <= 0 || d.rod_end->y < 15.5f);
  }
  EXPECT_FALSE(probe(35, 15).has_value());
  const auto without = probe_pixel(*wall.scene, wall.settings, nullptr, 8, 15);
  ASSERT_TRUE(without.value().has_value());
  EXPECT_FALSE(without.value()->state.has_value());
}

TEST(PixelProbe, NamesACoordinateOutsideOfThePicture) {
  const Wall wall;
  EXPECT_EQ(probe_pixel(*wall.scene, wall.settings, nullptr, 40, 0).error().where, "/x");
  EXPECT_EQ(probe_pixel(*wall.scene, wall.settings, nullptr, 0, -1).error().where, "/y");
}

}  // namespace
}  // namespace qray
