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

// What Mitsuba 3.9.1 (scalar_rgb) makes of its sunsky plugin, over turbidity, the sun's height and
// the ground's albedo.
TEST(SunSky, IsMitsuba3sSky) {
  const struct {
    double turbidity, sun_deg;
    float albedo;
    int row, column;  // of a picture of 720 x 360
    Rgb radiance;
  } points[] = {
      {1, 10, 0.3f, 20, 540, {0.007975f, 0.01666f, 0.02978f}},
      {1, 10, 0.3f, 120, 360, {0.0343f, 0.05587f, 0.07713f}},
      {1, 10, 0.3f, 120, 719, {0.03027f, 0.04932f, 0.06847f}},
      {1, 10, 0.3f, 178, 600, {0.09789f, 0.1092f, 0.06902f}},
      {2.5, 60, 0.0f, 20, 540, {0.02538f, 0.0408f, 0.0835f}},
      {2.5, 60, 0.0f, 120, 360, {0.0608f, 0.09354f, 0.1589f}},
      {2.5, 60, 0.0f, 120, 719, {0.02657f, 0.05212f, 0.1067f}},
      {2.5, 60, 0.0f, 178, 600, {0.1053f, 0.1362f, 0.1553f}},
      {3, 30, 0.3f, 20, 540, {0.01684f, 0.03199f, 0.06354f}},
      {3, 30, 0.3f, 120, 360, {0.2405f, 0.2586f, 0.2569f}},
      {3, 30, 0.3f, 120, 719, {0.03675f, 0.06605f, 0.1129f}},
      {3, 30, 0.3f, 178, 600, {0.1254f, 0.1581f, 0.1579f}},
      {6, 5, 1.0f, 20, 540, {0.009577f, 0.01512f, 0.0211f}},
      {6, 5, 1.0f, 120, 360, {0.1063f, 0.08504f, 0.05742f}},
      {6, 5, 1.0f, 120, 719, {0.03262f, 0.04104f, 0.04408f}},
      {6, 5, 1.0f, 178, 600, {0.04594f, 0.03667f, 0.02337f}},
      {6.7, 45, 0.5f, 20, 540, {0.05272f, 0.07298f, 0.1124f}},
      {6.7, 45, 0.5f, 120, 360, {0.5439f, 0.549f, 0.5125f}},
      {6.7, 45, 0.5f, 120, 719, {0.05648f, 0.09022f, 0.1446f}},
      {6.7, 45, 0.5f, 178, 600, {0.1737f, 0.1755f, 0.18f}},
      {10, 80, 0.2f, 20, 540, {0.7267f, 0.6857f, 0.6146f}},
      {10, 80, 0.2f, 120, 360, {0.1757f, 0.2006f, 0.2227f}},
      {10, 80, 0.2f, 120, 719, {0.1015f, 0.1165f, 0.151f}},
      {10, 80, 0.2f, 178, 600, {0.1403f, 0.1201f, 0.1176f}},
  };
  for (const auto& point : points) {
    SunSky p = at(point.sun_deg);
    p.turbidity = point.turbidity;
    p.albedo = Rgb{point.albedo};
    p.sun_scale = 0;
    const Rgb got = draw_sun_sky(p, 720, 360).rgb(point.column, point.row);
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(got[c] / point.radiance[c], 1, 2e-3)
          << "turbidity " << point.turbidity << ", the sun at " << point.sun_deg << ", row "
          << point.row << ", channel " << c;
  }
}

TEST(SunSky, HasMitsuba3sSun) {
  const struct {
    double turbidity, sun_deg;
    Rgb radiance;  // of the disk
  } suns[] = {
      {1, 60, {22508, 18902, 14535}},        {2.5, 30, {20592, 16225, 10793}},
      {3, 70, {22051, 18589, 14541}},        {6.5, 45, {18855, 15282, 11335}},
      {10, 10, {1533.5f, 767.31f, 318.69f}},
  };
  const double disk =
      2 * std::numbers::pi * (1 - std::cos(kSunDegrees / 2 * std::numbers::pi / 180));
  for (const auto& sun : suns) {
    SunSky p = at(sun.sun_deg);
    p.turbidity = sun.turbidity;
    p.sky_scale = 0;
    const Image image = draw_sun_sky(p, 1024, 512);
    for (int c = 0; c < 3; ++c) {
      double sum = 0;  // over solid angle
      for (int y = 0; y < 256; ++y)
        for (int x = 0; x < 1024; ++x)
          sum += static_cast<double>(image.rgb(x, y)[c]) * 2 * std::numbers::pi / 1024 *
                 std::numbers::pi / 512 * std::sin((y + 0.5) / 512 * std::numbers::pi);
      EXPECT_NEAR(sum / disk / static_cast<double>(sun.radiance[c]), 1, 1e-2)
          << "turbidity " << sun.turbidity << ", the sun at " << sun.sun_deg << ", channel " << c;
    }
  }
}

TEST(SunSky, NothingShinesFromBelowTheHorizon) {
  const auto below = [](const SunSky& p) {
    const Image image = draw_sun_sky(p, 256, 128);
    float most = 0;
    for (int y = 64; y < 128; ++y)
      for (int x = 0; x < 256; ++x) most = std::max(most, max_component(image.rgb(x, y)));
    return most;
  };
  SunSky p = at(0.1);  // its disk is cut by the horizon
  p.sun_model = SunModel::kPreetham;
  EXPECT_EQ(below(p), 0);
  p.extend = true;
  p.sun_scale = 0;
  EXPECT_GT(below(p), 0);
  p = at(-1);
  EXPECT_EQ(luminance(draw_sun_sky(p, 64, 32).rgb(32, 15)), 0);
}

TEST(SunSky, TheSunsLightDoesNotDependOnThePixels) {
  SunSky p = at(40);
  p.sky_scale = 0;
  const double fine = illuminance_lux(draw_sun_sky(p, 2048, 1024));
  EXPECT_NEAR(illuminance_lux(draw_sun_sky(p, 256, 128)) / fine, 1, 0.01);
  p.sun_radius_scale = 5;
  EXPECT_NEAR(illuminance_lux(draw_sun_sky(p, 2048, 1024)) / fine, 1, 0.01);
  p.sun_radius_scale = 0;
  EXPECT_NEAR(illuminance_lux(draw_sun_sky(p, 1024, 512)) / fine, 1, 0.01);
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

// In 0.x "scale" is what "skyScale" and "sunScale" are where they are not given.
TEST(SunSky, MitsubasScalesAndApertures) {
  const test::SceneFolder folder;
  const auto brightest = [&](const std::string& parameters) {
    const auto loaded = folder.load(
        "scene.xml",
        test::mitsuba_scene("<emitter type=\"sunsky\">" + parameters +
                            "<vector name=\"sunDirection\" value=\"1 2 3\"/></emitter>"));
    EXPECT_TRUE(loaded.ok()) << loaded.error().text();
    float most = 0;
    for (const float v : loaded.value().scene.environment.image.data()) most = std::max(most, v);
    return most;
  };
  const float sun = brightest("");
  EXPECT_FLOAT_EQ(brightest("<float name=\"scale\" value=\"0\"/>"
                            "<float name=\"sunScale\" value=\"1\"/>"),
                  brightest("<float name=\"skyScale\" value=\"0\"/>"));
  EXPECT_LT(brightest("<float name=\"scale\" value=\"0.001\"/>"), sun * 0.002f);
  EXPECT_LT(brightest("<float name=\"sunAperture\" value=\"5.358\"/>"), sun * 0.05f);
}

TEST(SunSky, ASunBelowTheHorizonIsWarnedOf) {
  const test::SceneFolder folder;
  const auto loaded = folder.load(
      "scene.xml", test::mitsuba_scene("<emitter type=\"sunsky\"><vector name=\"sunDirection\" "
                                       "x=\"0\" y=\"-1\" z=\"3\"/></emitter>",
                                       "0.6.0"));
  ASSERT_TRUE(loaded.ok()) << loaded.error().text();
  EXPECT_TRUE(std::any_of(
      loaded.value().warnings.begin(), loaded.value().warnings.end(),
      [](const std::string& w) { return w.find("below the horizon") != std::string::npos; }));
}

TEST(SunSky, MitsubasPluginsDrawIt) {
  const test::SceneFolder folder;
  for (const char* version : {"0.6.0", "3.0.0"}) {
    for (const char* type : {"sky", "sun", "sunsky"}) {
      const auto loaded = folder.load(
          "scene.xml", test::mitsuba_scene(std::string("<emitter type=\"") + type +
                                               "\"><float name=\"turbidity\" value=\"6\"/><vector "
                                               "name=\"sunDirection\" x=\"1\" y=\"2\" "
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
      // A sky's glow leans to the horizon.
      EXPECT_GT(dot(brightest, normalize(Vec3{1, 2, 3})),
                type == std::string("sky") ? 0.99f : 0.999f)
          << type << " " << version;
    }
  }
}

}  // namespace
}  // namespace qray
