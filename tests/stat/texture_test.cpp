// Textures in pictures: as coarse as pixels allow, no coarser.
#include <gtest/gtest.h>

#include "core/image/image_io.h"
#include "tests/support/random.h"
#include "tests/support/render.h"
#include "tests/support/scratch.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

constexpr int kTexels = 2048, kTextureSide = 64;

// Waves eight pixels long under noise of single texels.
Image waves_and_noise() {
  Image image(kTexels, kTexels, 3);
  test::Random random(1);
  for (int y = 0; y < kTexels; ++y)
    for (int x = 0; x < kTexels; ++x) {
      const float period = 8.0f * kTexels / kTextureSide;
      const float wave = std::sin(2 * kPi * static_cast<float>(x + y / 2) / period);
      image.set_rgb(x, y, Rgb{0.4f + 0.15f * wave + 0.4f * (random.next() - 0.5f)});
    }
  return image;
}

// A floor of 2 m, filled by the picture, lit from straight above.
Scene floor(const std::filesystem::path& path) {
  Scene scene;
  scene.name = "floor";
  test::add_quad(scene, test::add_material(scene, Rgb{1}), {-1, 0, 1}, {2, 0, 0}, {0, 0, -2});
  scene.meshes[0].uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  scene.textures.resize(1);
  scene.textures[0].path = path;
  scene.materials[0].reflectance.texture = TextureId(0);
  PunctualLight sun;
  sun.kind = LightKind::kDirectional;
  sun.direction = {0, -1, 0};
  sun.intensity = Rgb{kPi};
  scene.lights = {sun};
  scene.camera.position = {0, 10, 0};
  scene.camera.up = {0, 0, -1};
  scene.camera.target = {0, 0, 0};
  scene.camera.vertical_fov_deg = 2 * std::atan(0.1f) * 180 / kPi;
  return scene;
}

TEST(Texture, AFloorIsItsPicture) {
  const test::ScratchFolder folder;
  const Image picture = waves_and_noise();
  ASSERT_TRUE(write_image(folder / "t.png", picture).ok());
  const auto scene = test::prepare(floor(folder / "t.png"));
  const Image image = test::render(*scene, test::small_settings("none", kTextureSide, 64)).image;
  constexpr int kStep = kTexels / kTextureSide;
  double square = 0, wave = 0, product = 0;
  for (int y = 0; y < kTextureSide; ++y) {
    for (int x = 0; x < kTextureSide; ++x) {
      double mean = 0;
      for (int j = 0; j < kStep; ++j)
        for (int i = 0; i < kStep; ++i)
          mean += luminance(picture.rgb(x * kStep + i, y * kStep + j)) / (kStep * kStep);
      const double got = luminance(image.rgb(x, y));
      square += (got - mean) * (got - mean);
      wave += (mean - 0.4) * (mean - 0.4);
      product += (mean - 0.4) * (got - 0.4);
    }
  }
  // The root mean square error, against a mean of 0.4; and how much of the waves is left.
  EXPECT_LT(std::sqrt(square / (kTextureSide * kTextureSide)), 0.006);
  EXPECT_NEAR(product / wave, 1, 0.02);
}

TEST(Texture, VertexColoursMultiplyTheReflectance) {
  const test::ScratchFolder folder;
  Image white(2, 2, 3);
  for (float& v : white.data()) v = 0.5f;
  ASSERT_TRUE(write_image(folder / "t.exr", white).ok());
  for (const bool textured : {false, true}) {
    Scene scene = floor(folder / "t.exr");
    scene.textures[0].srgb = false;
    if (!textured) {
      scene.materials[0].reflectance = {Rgb{0.5f}, {}};
      scene.meshes[0].uvs.clear();
    }
    // Red grows to the right.
    scene.meshes[0].colors = {{0, 1, 0.5f}, {1, 1, 0.5f}, {1, 1, 0.5f}, {0, 1, 0.5f}};
    const auto prepared = test::prepare(scene);
    const Image image = test::render(*prepared, test::small_settings("none", 16, 64)).image;
    for (int x = 0; x < 16; ++x) {
      const Rgb c = image.rgb(x, 7);
      EXPECT_NEAR(c.r, 0.5 * (x + 0.5) / 16, 0.01) << x;
      EXPECT_NEAR(c.g, 0.5, 0.002);
      EXPECT_NEAR(c.b, 0.25, 0.002);
    }
  }
}

}  // namespace
}  // namespace qray
