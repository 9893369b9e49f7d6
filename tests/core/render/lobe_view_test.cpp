#include "core/render/lobe_view.h"

#include <gtest/gtest.h>

#include "core/guide/huang.h"
#include "core/image/false_color.h"
#include "tests/core/render/wall.h"

namespace qray {
namespace {

using test::Wall;

HuangGuide taught(const Wall& wall, Vec3 bright) {
  HuangGuide guide(HuangGuide::Density::kExact, wall.scene->bounds, {});
  HuangGuide::Values values{};
  values[static_cast<size_t>(nearest_direction26(bright))] = 1;
  // The states of all places on the wall.
  for (float y = -1.99f; y < 2; y += 0.05f)
    for (float x = -1.99f; x < 0; x += 0.05f)
      guide.set_values(guide.find({x, y, 0}, {0, 0, 1}).key, values);
  guide.end_pass();
  return guide;
}

GuidePoint point_on_wall(const Guide& guide) { return guide.find({-0.5f, 0.01f, 0}, {0, 0, 1}); }

// The pixels of the world's axes (header).
constexpr int kMiddle = kLobeWidth / 2, kQuarter = kLobeWidth / 4, kEquator = kLobeHeight / 2;

TEST(LobeView, ShowsTheDensityOfEachDirection) {
  const Wall wall;
  const HuangGuide guide = taught(wall, {0, 0, 1});
  const Result<LobeView> view = render_lobe_view(*wall.scene, wall.settings, guide, 8, 15);
  ASSERT_TRUE(view.ok()) << view.error().text();
  EXPECT_TRUE(view.value().known);
  const Image& image = view.value().image;
  ASSERT_EQ(image.width(), kLobeWidth + kLobeHeight);  // with the cube
  ASSERT_EQ(image.height(), kLobeHeight);
  const auto color = [&](Vec3 w) {
    return viridis(log_scale(guide.pdf_w(point_on_wall(guide), w), kLobeLow, kLobeHigh));
  };
  EXPECT_EQ(image.rgb(kMiddle, kEquator), color({0, 0, 1}));
  EXPECT_EQ(image.rgb(kMiddle, 20), color(normalize({0, 1, 0.25f})));
  EXPECT_NE(color({0, 0, 1}), color(normalize({0, 1, 0.25f})));
  for (int x : {0, kLobeWidth - 1}) {
    const Rgb into_the_wall = image.rgb(x, kEquator);
    EXPECT_EQ(into_the_wall.r, into_the_wall.b);
    EXPECT_GT(into_the_wall.r, 0.1f);
  }
}

TEST(LobeView, AxesAreWhereTheHeaderSays) {
  const Wall wall;
  const auto luminance_at = [&](Vec3 bright, int x, int y) {
    const HuangGuide guide = taught(wall, normalize(bright));
    return luminance(
        render_lobe_view(*wall.scene, wall.settings, guide, 8, 15).value().image.rgb(x, y));
  };
  const int left = kMiddle - kQuarter / 2, right = kMiddle + kQuarter / 2;
  EXPECT_GT(luminance_at({1, 0, 1}, left, kEquator), 2 * luminance_at({1, 0, 1}, right, kEquator));
  EXPECT_GT(luminance_at({-1, 0, 1}, right, kEquator),
            2 * luminance_at({-1, 0, 1}, left, kEquator));
  const int above = kEquator / 2, below = kEquator + kEquator / 2;
  EXPECT_GT(luminance_at({0, 1, 1}, kMiddle, above), 2 * luminance_at({0, 1, 1}, kMiddle, below));
  EXPECT_GT(luminance_at({0, -1, 1}, kMiddle, below), 2 * luminance_at({0, -1, 1}, kMiddle, above));
}

TEST(LobeView, WhereNothingIsKnownTheHemisphereIsBlack) {
  const Wall wall;
  for (const char* method : {"huang", "dahm-keller", "ppg", "adaptive"}) {
    const auto guide = make_guide(method, wall.scene->guide_setup(wall.settings));
    const Result<LobeView> view =
        render_lobe_view(*wall.scene, wall.settings, *guide.value(), 8, 15);
    ASSERT_TRUE(view.ok()) << method;
    EXPECT_FALSE(view.value().known) << method;
    EXPECT_TRUE(view.value().image.rgb(kMiddle, kEquator).is_black()) << method;
    EXPECT_FALSE(view.value().image.rgb(0, kEquator).is_black()) << method;
  }
}

TEST(LobeView, NamesTheCoordinateThatIsWrong) {
  const Wall wall;
  const HuangGuide guide = taught(wall, {0, 0, 1});
  struct {
    int x, y;
    const char* where;
  } const cases[] = {{-1, 0, "/x"}, {40, 0, "/x"}, {0, -1, "/y"}, {0, 30, "/y"}, {35, 15, "/x"}};
  for (const auto& c : cases) {
    const Result<LobeView> view = render_lobe_view(*wall.scene, wall.settings, guide, c.x, c.y);
    ASSERT_FALSE(view.ok()) << c.x << "," << c.y;
    EXPECT_EQ(view.error().code, ErrorCode::kInvalid);
    EXPECT_EQ(view.error().where, c.where) << c.x << "," << c.y;
  }
}

}  // namespace
}  // namespace qray
