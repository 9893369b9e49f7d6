#include "core/import/sun_sky.h"

#include <gtest/gtest.h>

#include "tests/core/import/mitsuba_text.h"

namespace qray {
namespace {

constexpr double kLumen = 683 * 106.857;  // cd/m^2 a unit of luminance

// Of the hemisphere, on level ground.
double illuminance_lux(const Image& image) {
  double sum = 0;
  const int w = image.width(), h = image.height();
  for (int y = 0; y < h / 2; ++y) {
    const double theta = (y + 0.5) / h * std::numbers::pi;
    const double weight =
        2 * std::numbers::pi / w * std::numbers::pi / h * std::sin(theta) * std::cos(theta);
    for (int x = 0; x < w; ++x) sum += weight * double{luminance(image.rgb(x, y))};
  }
  return sum * kLumen;
}

SunSky at(double elevation_deg) {
  SunSky p;
  const double e = elevation_deg * std::numbers::pi / 180;
  p.to_sun = {0, static_cast<float>(std::sin(e)), static_cast<float>(-std::cos(e))};
  return p;
}

// Handbooks have 10 to 25 klx of a deep blue sky, more of a hazy one (turbidity 3 is a little), and
// 80 to 110 klx with a high sun.
TEST(SunSky, LightsTheGroundAsDaylightDoes) {
  SunSky p = at(60);
  const double both = illuminance_lux(draw_sun_sky(p, 512, 256));
  EXPECT_GT(both, 75e3);
  EXPECT_LT(both, 115e3);
  p.sun_scale = 0;
  const double sky = illuminance_lux(draw_sun_sky(p, 512, 256));
  EXPECT_GT(sky, 8e3);
  EXPECT_LT(sky, 40e3);
}

TEST(SunSky, TheSunsLightDoesNotDependOnThePixels) {
  SunSky p = at(40);
  p.sky_scale = 0;
  const double fine = illuminance_lux(draw_sun_sky(p, 2048, 1024));
  EXPECT_NEAR(illuminance_lux(draw_sun_sky(p, 256, 128)) / fine, 1, 0.01);
  p.sun_radius_scale = 5;
  EXPECT_NEAR(illuminance_lux(draw_sun_sky(p, 2048, 1024)) / fine, 1, 0.01);
}

TEST(SunSky, IsBlueAboveAndBrightestAtTheSun) {
  const Image image = draw_sun_sky(at(30), 256, 128);
  const Rgb zenith = image.rgb(0, 2);
  EXPECT_GT(zenith.b, 1.3f * zenith.r);
  int best_x = 0, best_y = 0;
  float best = 0;
  for (int y = 0; y < 128; ++y)
    for (int x = 0; x < 256; ++x)
      if (luminance(image.rgb(x, y)) > best) {
        best = luminance(image.rgb(x, y));
        best_x = x;
        best_y = y;
      }
  EXPECT_NEAR(best_x, 128, 1);  // the centre is -z
  EXPECT_NEAR(best_y, 60.0 / 180 * 128, 1);
  for (int y = 0; y < 128; ++y)
    for (int x = 0; x < 256; ++x)
      EXPECT_TRUE(std::isfinite(luminance(image.rgb(x, y)))) << x << " " << y;
}

// Greenwich, 20 March 2020 (equinox), 12:07 UT, when the sun crossed the meridian: as high as the
// latitude is from the pole. And a summer's noon in Tokyo.
TEST(SunSky, TheSunStandsWhereAlmanacsHaveIt) {
  const auto elevation = [](Vec3 d) { return std::asin(d.y) * 180 / kPi; };
  const Vec3 equinox = sun_direction({2020, 3, 20, 12 + 7.5 / 60, 0, 51.48, 0});
  EXPECT_NEAR(elevation(equinox), 90 - 51.48, 0.2);
  EXPECT_NEAR(equinox.x, 0, 0.01);
  EXPECT_GT(equinox.z, 0);  // in the south
  const Vec3 morning = sun_direction({2020, 3, 20, 6 + 7.5 / 60, 0, 51.48, 0});
  EXPECT_NEAR(elevation(morning), 0, 0.4);
  EXPECT_NEAR(morning.x, 1, 0.01);  // rises in the east
  const Vec3 solstice = sun_direction({2021, 6, 21, 11.72, 9, 35.6894, 139.6917});
  EXPECT_NEAR(elevation(solstice), 90 - 35.6894 + 23.44, 0.2);
}

TEST(SunSky, MitsubasPluginsDrawIt) {
  const test::SceneFolder folder;
  for (const char* version : {"0.6.0", "3.0.0"}) {
    for (const char* type : {"sky", "sun", "sunsky"}) {
      const auto loaded = folder.load(
          "scene.xml", test::mitsuba_scene(std::string("<emitter type=\"") + type +
                                               "\"><vector name=\"sunDirection\" x=\"1\" y=\"2\" "
                                               "z=\"3\"/></emitter>",
                                           version));
      ASSERT_TRUE(loaded.ok()) << loaded.error().text();
      const Environment& sky = loaded.value().scene.environment;
      // The brightest pixel lies toward the sun.
      Vec3 brightest;
      float best = -1;
      const int w = sky.image.width(), h = sky.image.height();
      for (int y = 0; y < h; ++y) {
        for (int x = 0; x < w; ++x) {
          if (luminance(sky.image.rgb(x, y)) <= best) continue;
          best = luminance(sky.image.rgb(x, y));
          const float phi =
              2 * kPi * ((static_cast<float>(x) + 0.5f) / static_cast<float>(w) - 0.5f);
          const float theta = kPi * (static_cast<float>(y) + 0.5f) / static_cast<float>(h);
          brightest = sky.to_world * Vec3{std::sin(theta) * std::sin(phi), std::cos(theta),
                                          -std::sin(theta) * std::cos(phi)};
        }
      }
      EXPECT_GT(dot(brightest, normalize(Vec3{1, 2, 3})), 0.999f) << type << " " << version;
    }
  }
}

}  // namespace
}  // namespace qray
