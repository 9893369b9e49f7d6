#include "core/image/image_io.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "core/base/file.h"
#include "tests/support/scratch.h"

namespace qray {
namespace {

Image gradient(int channels) {
  Image image(5, 3, channels);
  float v = 0;
  for (float& x : image.data()) x = v += 0.013f;
  return image;
}

TEST(ImageIo, ExrKeepsEveryBitAndTheMetadata) {
  const test::ScratchFolder folder;
  Image image = gradient(3);
  image.set_rgb(1, 2, {-3.5f, 1e20f, 1e-20f});
  const ImageMetadata metadata{{"seed", "7"}, {"method", "huang"}, {"scene_hash", "00ff"}};
  ASSERT_TRUE(write_image(folder / "a.exr", image, metadata).ok());

  const Result<Image> back = read_image(folder / "a.exr");
  ASSERT_TRUE(back.ok()) << back.error().text();
  ASSERT_EQ(back.value().width(), 5);
  ASSERT_EQ(back.value().height(), 3);
  ASSERT_EQ(back.value().channels(), 3);
  for (size_t i = 0; i < image.data().size(); ++i)
    EXPECT_EQ(back.value().data()[i], image.data()[i]) << i;

  const Result<ImageMetadata> read = read_image_metadata(folder / "a.exr");
  ASSERT_TRUE(read.ok());
  for (const auto& [name, value] : metadata) EXPECT_EQ(read.value().at(name), value) << name;
}

TEST(ImageIo, ARowIsTheSameReadAlone) {
  const test::ScratchFolder folder;
  Image image(70, 40, 4);  // more than one block of an EXR, of 16 rows
  float v = 0;
  for (float& x : image.data()) x = v += 0.013f;
  ASSERT_TRUE(write_image(folder / "a.exr", image).ok());
  for (const int y : {0, 15, 16, 39}) {
    const Result<Image> row = read_image_row(folder / "a.exr", y);
    ASSERT_TRUE(row.ok()) << row.error().text();
    ASSERT_EQ(row.value().width(), 70);
    ASSERT_EQ(row.value().height(), 1);
    ASSERT_EQ(row.value().channels(), 4);
    for (int x = 0; x < 70; ++x)
      for (int c = 0; c < 4; ++c) EXPECT_EQ(row.value().at(x, 0, c), image.at(x, y, c));
  }
  for (const int y : {-1, 40})
    EXPECT_EQ(read_image_row(folder / "a.exr", y).error().code, ErrorCode::kInvalid);
  EXPECT_EQ(read_image_row(folder / "b.exr", 0).error().code, ErrorCode::kNotFound);
}

TEST(ImageIo, BytesDoNotDependOnTheTime) {
  const auto encode_all = [] {
    std::vector<Bytes> all;
    for (const ImageFormat format :
         {ImageFormat::kExr, ImageFormat::kPng, ImageFormat::kJpeg, ImageFormat::kWebp}) {
      Result<Bytes> bytes = encode_image(format, gradient(3), {{"seed", "1"}});
      EXPECT_TRUE(bytes.ok());
      all.push_back(std::move(bytes).value());
    }
    return all;
  };
  const std::vector<Bytes> before = encode_all();
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // dates count whole seconds
  EXPECT_EQ(encode_all(), before);
}

TEST(ImageIo, PngIsSrgbOfTheClampedPicture) {
  const test::ScratchFolder folder;
  Image image(4, 1, 3);
  image.set_rgb(0, 0, {0, 1, 2});
  image.set_rgb(1, 0, {0.5f, 0.214041f, 0.0031308f});  // sRGB 188, 127.5, 10.3 of 255
  image.set_rgb(2, 0, {-1, std::nanf(""), 0.002f});    // below the toe: 12.92 * .002 * 255 = 6.6
  ASSERT_TRUE(write_image(folder / "a.png", image, {{"seed", "7"}}).ok());
  const Result<Image> back = read_image(folder / "a.png");
  ASSERT_TRUE(back.ok()) << back.error().text();
  const auto byte = [&](int x, int c) { return std::lround(back.value().at(x, 0, c) * 255); };
  EXPECT_EQ(byte(0, 0), 0);
  EXPECT_EQ(byte(0, 1), 255);
  EXPECT_EQ(byte(0, 2), 255);
  EXPECT_EQ(byte(1, 0), 188);
  EXPECT_NEAR(byte(1, 1), 127.5, 0.6);
  EXPECT_EQ(byte(1, 2), 10);
  EXPECT_EQ(byte(2, 0), 0);
  EXPECT_EQ(byte(2, 1), 0);
  EXPECT_EQ(byte(2, 2), 7);
  EXPECT_EQ(read_image_metadata(folder / "a.png").value().at("seed"), "7");
}

TEST(ImageIo, GrayAndAlphaChannelsSurvive) {
  const test::ScratchFolder folder;
  for (const int channels : {1, 2, 4}) {
    const std::filesystem::path path = folder / ("c" + std::to_string(channels) + ".exr");
    ASSERT_TRUE(write_image(path, gradient(channels)).ok());
    const Result<Image> back = read_image(path);
    ASSERT_TRUE(back.ok()) << back.error().text();
    EXPECT_EQ(back.value().channels(), channels);
    EXPECT_EQ(back.value().at(4, 2, 0), gradient(channels).at(4, 2, 0));
  }
}

TEST(ImageIo, ErrorsNameTheFileAndTheCause) {
  const test::ScratchFolder folder;
  const std::filesystem::path missing = folder / "none.exr";
  EXPECT_EQ(read_image(missing).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(read_image(missing).error().where, missing.string());
  EXPECT_EQ(read_image_metadata(missing).error().code, ErrorCode::kNotFound);

  const Bytes text{'n', 'o', ' ', 'p', 'i', 'c', 't', 'u', 'r', 'e'};
  ASSERT_TRUE(write_file_atomic(folder / "text.png", text).ok());
  EXPECT_EQ(read_image(folder / "text.png").error().code, ErrorCode::kInvalid);

  ASSERT_TRUE(write_image(folder / "a.png", gradient(3)).ok());
  EXPECT_EQ(read_image(folder / "a.png", 14).error().code, ErrorCode::kTooLarge);
  EXPECT_TRUE(read_image(folder / "a.png", 15).ok());

  EXPECT_EQ(write_image(folder / "a.jpg", gradient(3)).error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(write_image(folder / "no_folder" / "a.png", gradient(3)).error().code, ErrorCode::kIo);
  EXPECT_EQ(encode_image(ImageFormat::kPng, Image{}).error().code, ErrorCode::kInvalid);
}

TEST(ImageIo, ATruncatedFileIsAnErrorNotAPicture) {
  const test::ScratchFolder folder;
  Image image(64, 64, 3);
  for (size_t i = 0; i < image.data().size(); ++i)
    image.data()[i] = static_cast<float>(i * 2654435761u % 1000) / 1000;
  for (const ImageFormat format : {ImageFormat::kExr, ImageFormat::kPng}) {
    Bytes bytes = encode_image(format, image).value();
    bytes.resize(bytes.size() / 2);
    const auto path = folder / (format == ImageFormat::kExr ? "t.exr" : "t.png");
    ASSERT_TRUE(write_file_atomic(path, bytes).ok());
    const Result<Image> back = read_image(path);
    ASSERT_FALSE(back.ok());
    EXPECT_EQ(back.error().where, path.string());
  }
}

}  // namespace
}  // namespace qray
