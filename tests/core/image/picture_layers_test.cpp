#include "core/image/picture_layers.h"

#include <gtest/gtest.h>

#include "core/image/layer_view.h"
#include "tests/support/scratch.h"

namespace qray {
namespace {

Image numbers(int channels, float first) {
  Image image(5, 70, channels);  // more rows than are written at once
  for (float& v : image.data()) v = first++;
  return image;
}

std::vector<PictureLayer> some() {
  return {{"", "RGB", numbers(3, 0)},
          {"normal", "XYZ", numbers(3, 5000)},
          {"CryptoObject00", "rgba", numbers(4, 9000)},
          {"depth", "Z", numbers(1, -700)}};
}

TEST(PictureLayers, ComeBackByTheirNames) {
  const test::ScratchFolder scratch;
  const auto file = scratch / "layers.exr";
  const std::vector<PictureLayer> layers = some();
  ASSERT_TRUE(write_layers(file, layers, {{"seed", "7"}, {"cryptomatte/0123456/name", "x"}}).ok());
  const Result<std::vector<std::string>> names = read_layer_names(file);
  ASSERT_TRUE(names.ok());
  EXPECT_EQ(names.value().size(), layers.size());
  for (const PictureLayer& layer : layers) {
    const Result<PictureLayer> read = read_layer(file, layer.name);
    ASSERT_TRUE(read.ok()) << layer.name << ": " << read.error().text();
    EXPECT_EQ(read.value().channels, layer.channels);
    ASSERT_EQ(read.value().image.data().size(), layer.image.data().size());
    EXPECT_TRUE(std::ranges::equal(read.value().image.data(), layer.image.data())) << layer.name;
  }
  EXPECT_EQ(read_layer(file, "uv").error().code, ErrorCode::kNotFound);
  const Result<ImageMetadata> metadata = read_image_metadata(file);
  EXPECT_EQ(metadata.value().at("seed"), "7");
  EXPECT_EQ(metadata.value().at("cryptomatte/0123456/name"), "x");
  EXPECT_EQ(read_image(file).value().rgb(1, 0), (Rgb{3, 4, 5})) << "the picture comes first";
}

TEST(PictureLayers, LayersOfSeveralSizesAreRefused) {
  std::vector<PictureLayer> layers = some();
  layers.push_back({"small", "Z", Image(2, 2, 1)});
  EXPECT_EQ(encode_layers(layers, {}).error().where, "small");
}

TEST(LayerView, ShowsEachKindOfNumbers) {
  const Image normals = layer_view(some()[1]);
  EXPECT_EQ(normals.channels(), 3);
  PictureLayer unit{"normal", "XYZ", Image(1, 1, 3)};
  unit.image.set_rgb(0, 0, {1, -1, 0});
  EXPECT_FLOAT_EQ(layer_view(unit).at(0, 0, 0), 1);
  EXPECT_FLOAT_EQ(layer_view(unit).at(0, 0, 1), 0);
  PictureLayer depth{"depth", "Z", Image(3, 1, 1)};
  depth.image.at(0, 0, 0) = 2;
  depth.image.at(1, 0, 0) = 4;
  depth.image.at(2, 0, 0) = 1e10f;
  const Image view = layer_view(depth);
  EXPECT_GT(view.at(1, 0, 1), view.at(0, 0, 1)) << "viridis rises in lightness";
  EXPECT_EQ(view.rgb(2, 0), Rgb{}) << "nothing is there";
}

}  // namespace
}  // namespace qray
