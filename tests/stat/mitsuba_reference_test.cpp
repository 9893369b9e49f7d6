// The importer against a picture that another renderer made of the same file.
#include <gtest/gtest.h>

#include "core/image/image_io.h"
#include "tests/support/places.h"
#include "tests/support/render.h"

namespace qray {
namespace {

// The mean of each block of pixels.
Image reduced(const Image& image, int width, int height) {
  Image out(width, height, 3);
  const int w = image.width() / width, h = image.height() / height;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      Rgb sum;
      for (int i = 0; i < w * h; ++i) sum += image.rgb(x * w + i % w, y * h + i / w);
      out.set_rgb(x, y, sum / static_cast<float>(w * h));
    }
  }
  return out;
}

// ../shared/testdata/README.md trusts this reference to 0.03 %. The file of version 0.5 has the
// same walls without `twosided`, three of them with their backs to the room: black, as in Mitsuba.
TEST(MitsubaReference, CornellBoxHasItsLightEverywhere) {
  const std::filesystem::path folder = test::testdata_dir() / "cornell-box";
  if (!std::filesystem::is_directory(folder))
    GTEST_SKIP() << "no test data: " << folder << " is not there";
  const auto scene = load_and_prepare_scene(folder / "scene_v3.xml", 2);
  ASSERT_TRUE(scene.ok()) << scene.error().text();
  RenderSettings settings = test::small_settings("none", 128, 96);
  settings.max_depth = scene.value()->scene.max_depth;
  const Image image = test::render(*scene.value(), settings).image;
  const Image reference = read_image(folder / "reference/TungstenRender.exr").value();
  const Image whole = reduced(image, 1, 1), expected = reduced(reference, 1, 1);
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(whole.rgb(0, 0)[c] / expected.rgb(0, 0)[c], 1, 0.01) << "channel " << c;
  // Left and right, up and down: sixteen blocks, of which the noise is below 1 %.
  const Image blocks = reduced(image, 4, 4), expected_blocks = reduced(reference, 4, 4);
  for (int i = 0; i < 16; ++i) {
    const int x = i % 4, y = i / 4;
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(blocks.rgb(x, y)[c] / expected_blocks.rgb(x, y)[c], 1, 0.04)
          << "block " << x << ", " << y << ", channel " << c;
  }
}

}  // namespace
}  // namespace qray
