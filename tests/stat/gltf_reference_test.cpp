// The same scene as Mitsuba's XML and as glTF: the two importers agree on its light.
#include <gtest/gtest.h>

#include "tests/support/places.h"
#include "tests/support/render.h"

namespace qray {
namespace {

// The converted file's walls are glTF's diffuse without a specular part, its lamp is
// KHR_materials_emissive_strength, and its meshes are instances.
TEST(GltfReference, CornellBoxIsMitsubas) {
  const std::filesystem::path data = test::testdata_dir();
  const std::filesystem::path files[] = {data / "cornell-box/scene_v3.xml",
                                         data / "xf-cornell-box/cornell-box.gltf"};
  Rgb means[2];
  for (int i = 0; i < 2; ++i) {
    if (!std::filesystem::exists(files[i]))
      GTEST_SKIP() << "no test data: " << files[i] << " is not there";
    const auto scene = load_and_prepare_scene(files[i], 2);
    ASSERT_TRUE(scene.ok()) << scene.error().text();
    RenderSettings settings = test::small_settings("none", 128, 96);
    settings.max_depth = 64;
    const Image image = test::render(*scene.value(), settings).image;
    for (int y = 0; y < image.height(); ++y)
      for (int x = 0; x < image.width(); ++x) means[i] += image.rgb(x, y);
    means[i] = means[i] / static_cast<float>(image.width() * image.height());
  }
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(means[1][c] / means[0][c], 1, 0.01) << "channel " << c;
}

}  // namespace
}  // namespace qray
