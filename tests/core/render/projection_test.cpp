// Whole pictures of cameras that are no pinhole, against what geometry says.
#include <gtest/gtest.h>

#include "core/render/environment_light.h"
#include "tests/support/render.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

// A panel of .5 x .25 m fills an eighth of 1 m^2, as near as far.
TEST(Projection, AnOrthographicPictureShowsAreas) {
  for (const float distance : {1.0f, 50.0f}) {
    Scene scene;
    const MaterialId light = test::add_material(scene, Rgb{0.0f}, Rgb{3.0f});
    test::add_quad(scene, light, {-0.25f, -0.125f, -distance}, {0.5f, 0, 0}, {0, 0.25f, 0});
    scene.camera.projection = Projection::kOrthographic;
    scene.camera.height = 1;
    const auto prepared = test::prepare(scene);
    const Image image = test::render(*prepared, test::small_settings("none", 64, 4)).image;
    EXPECT_NEAR(test::mean_luminance(image), 3.0 / 8, 1e-6) << distance;
    EXPECT_FLOAT_EQ(image.at(16, 24, 0), 3);
    EXPECT_FLOAT_EQ(image.at(15, 24, 0), 0);
  }
}

// A picture of all directions where there is but the sky is the sky's picture.
TEST(Projection, AnEquirectangularPictureOfTheSkyIsTheSky) {
  constexpr int kWidth = 64, kHeight = 32;
  Scene scene;
  test::add_quad(scene, test::add_material(scene, Rgb{0.5f}), {0, -900, 0}, {0, 0, 0.01f},
                 {0.01f, 0, 0});
  scene.environment.radiance = {1, 0.5f, 2};
  Image& sky = scene.environment.image = Image(kWidth, kHeight, 3);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const float longitude = (static_cast<float>(x) + 0.5f) / kWidth * 2 * kPi;
      const float level = std::sin((static_cast<float>(y) + 0.5f) / kHeight * kPi);
      sky.set_rgb(
          x, y,
          {1 + 0.5f * level * std::sin(longitude), 1 + 0.5f * std::cos(longitude), 2 + level});
    }
  scene.camera.position = {3, 1, 2};
  scene.camera.target = {3, 1, -7};
  scene.camera.projection = Projection::kEquirectangular;
  const CameraRays rays(scene.camera, kWidth, kHeight);
  const EnvironmentLight light(scene.environment);
  const auto prepared = test::prepare(scene);
  RenderSettings settings = test::small_settings("none", kHeight, 16);
  settings.width = kWidth;
  const Image image = test::render(*prepared, settings).image;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const Rgb expected = sky.rgb(x, y) * scene.environment.radiance;
      const Vec2 middle{static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f};
      const Rgb seen = light.radiance(rays.ray(middle, {}).d);
      for (int c = 0; c < 3; ++c) {
        ASSERT_NEAR(seen[c], expected[c], 1e-3f) << x << ", " << y;
        ASSERT_NEAR(image.at(x, y, c), expected[c], 0.05f) << x << ", " << y;  // over the pixel
      }
    }
}

}  // namespace
}  // namespace qray
