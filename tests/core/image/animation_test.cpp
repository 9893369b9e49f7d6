#include "core/image/animation.h"

#include <gtest/gtest.h>

#include <fstream>

#include "core/image/image_io.h"
#include "tests/support/scratch.h"

namespace qray {
namespace {

Animation grey_steps(int count) {
  return {count, 10, [count](int frame) -> Result<Image> {
            Image image(33, 20, 3);
            for (float& v : image.data())
              v = static_cast<float>(frame + 1) / static_cast<float>(count);
            return image;
          }};
}

std::string head_of(const std::filesystem::path& path, size_t size) {
  std::ifstream in(path, std::ios::binary);
  std::string head(size, '\0');
  in.read(head.data(), static_cast<std::streamsize>(size));
  return head;
}

TEST(AnimationFile, AGifHoldsAllPictures) {
  const test::ScratchFolder scratch;
  const std::filesystem::path path = scratch / "steps.gif";
  ASSERT_TRUE(write_animation(path, grey_steps(4)).ok());
  EXPECT_EQ(head_of(path, 6), "GIF89a");
  std::ifstream in(path, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(in), {});
  size_t pictures = 0;  // each has a graphic control extension of its own
  for (size_t at = 0; (at = bytes.find("\x21\xf9\x04", at)) != std::string::npos; ++at) ++pictures;
  EXPECT_EQ(pictures, 4u);
  const Result<Image> first = read_image(path);
  ASSERT_TRUE(first.ok());
  EXPECT_EQ(first.value().width(), 33);
  EXPECT_NEAR(first.value().at(5, 5, 0), 0.537, 0.02);  // sRGB of a quarter
}

TEST(AnimationFile, AnMp4NeedsFfmpeg) {
  const test::ScratchFolder scratch;
  const std::filesystem::path path = scratch / "steps.mp4";
  const Status written = write_animation(path, grey_steps(4));
  if (!has_ffmpeg()) {
    EXPECT_EQ(written.error().code, ErrorCode::kUnsupported);
    GTEST_SKIP() << "ffmpeg is not on this machine";
  }
  ASSERT_TRUE(written.ok()) << written.error().text();
  EXPECT_EQ(head_of(path, 8).substr(4), "ftyp");
}

TEST(AnimationFile, APictureThatFailsIsItsError) {
  const test::ScratchFolder scratch;
  Animation broken = grey_steps(3);
  broken.picture = [](int) -> Result<Image> { return Error{ErrorCode::kConflict, "none yet", ""}; };
  EXPECT_EQ(write_animation(scratch / "a.gif", broken).error().code, ErrorCode::kConflict);
  EXPECT_EQ(write_animation(scratch / "a.avi", grey_steps(2)).error().code,
            ErrorCode::kUnsupported);
}

}  // namespace
}  // namespace qray
