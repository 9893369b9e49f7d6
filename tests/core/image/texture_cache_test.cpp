#include "core/image/texture_cache.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "core/base/file.h"
#include "core/base/task_pool.h"
#include "core/image/image_io.h"
#include "core/image/tonemap.h"
#include "tests/support/scratch.h"

namespace qray {
namespace {

// 4 x 2 texels; rows from the top.
Image board() {
  Image image(4, 2, 3);
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 4; ++x)
      image.set_rgb(x, y, {static_cast<float>(x), static_cast<float>(y), 0.5f});
  return image;
}
// The middle of a texel, row counted from the top.
Vec2 middle(int x, int y) {
  return {(static_cast<float>(x) + 0.5f) / 4, 1 - (static_cast<float>(y) + 0.5f) / 2};
}

TEST(TextureCache, VZeroIsTheBottomRow) {
  const test::ScratchFolder folder;
  ASSERT_TRUE(write_image(folder / "t.exr", board()).ok());
  TextureCache cache;
  const Result<int> handle = cache.open(folder / "t.exr", /*srgb=*/false, TextureWrap::kRepeat);
  ASSERT_TRUE(handle.ok()) << handle.error().text();
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 4; ++x) {
      const Rgb c = cache.lookup(handle.value(), middle(x, y));
      EXPECT_NEAR(c.r, static_cast<float>(x), 1e-4) << x << " " << y;
      EXPECT_NEAR(c.g, static_cast<float>(y), 1e-4) << x << " " << y;
      EXPECT_NEAR(c.b, 0.5, 1e-4);
    }
}

TEST(TextureCache, AlphaIsOneWhereThereIsNone) {
  const test::ScratchFolder folder;
  Image with_alpha(4, 2, 4);
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 4; ++x) with_alpha.at(x, y, 3) = 0.25f * static_cast<float>(x);
  ASSERT_TRUE(write_image(folder / "a.exr", with_alpha).ok());
  ASSERT_TRUE(write_image(folder / "t.exr", board()).ok());
  TextureCache cache;
  const int with = cache.open(folder / "a.exr", /*srgb=*/true, TextureWrap::kRepeat).value();
  const int without = cache.open(folder / "t.exr", true, TextureWrap::kRepeat).value();
  for (int x = 0; x < 4; ++x) {
    EXPECT_NEAR(cache.lookup_alpha(with, middle(x, 1)), 0.25f * static_cast<float>(x), 1e-4);
    EXPECT_EQ(cache.lookup_alpha(without, middle(x, 1)), 1.0f);
  }
  EXPECT_EQ(cache.texel(with).x, 0.25f);
  EXPECT_EQ(cache.texel(with).y, 0.5f);
  EXPECT_EQ(cache.lookup_alpha(with, {1e30f, 0}), 0.0f);
}

TEST(TextureCache, AThreadThatGoesOnSeesEachCachesOwnPicture) {
  // Caches come and go, often at the same address, while the threads of a pool stay.
  const test::ScratchFolder folder;
  TaskPool pool(2);
  for (int i = 0; i < 40; ++i) {
    const float value = static_cast<float>(i);
    Image image(4, 4, 3);
    for (int k = 0; k < 16; ++k) image.set_rgb(k % 4, k / 4, Rgb{value});
    const std::filesystem::path path = folder / (std::to_string(i) + ".exr");
    ASSERT_TRUE(write_image(path, image).ok());
    TextureCache cache;
    const int handle = cache.open(path, /*srgb=*/false, TextureWrap::kRepeat).value();
    pool.run(64, [&](size_t, int) { EXPECT_EQ(cache.lookup(handle, {0.4f, 0.6f}).g, value); });
  }
}

TEST(TextureCache, InterpolatesAndWraps) {
  const test::ScratchFolder folder;
  ASSERT_TRUE(write_image(folder / "t.exr", board()).ok());
  TextureCache cache;
  const auto open = [&](TextureWrap wrap) {
    return cache.open(folder / "t.exr", false, wrap).value();
  };
  const int repeat = open(TextureWrap::kRepeat), clamp = open(TextureWrap::kClamp),
            mirror = open(TextureWrap::kMirror);
  const float v = middle(0, 0).y;
  EXPECT_NEAR(cache.lookup(repeat, {0.5f, v}).r, 1.5, 1e-3);  // between texels 1 and 2
  EXPECT_NEAR(cache.lookup(repeat, {0.5f + 0.0625f, v}).r, 1.75, 1e-3);
  EXPECT_NEAR(cache.lookup(repeat, {0, v}).r, 1.5, 1e-3);  // texels 3 and 0
  EXPECT_NEAR(cache.lookup(repeat, {1.125f, v}).r, 0, 1e-3);
  EXPECT_NEAR(cache.lookup(clamp, {1.125f, v}).r, 3, 1e-3);
  EXPECT_NEAR(cache.lookup(clamp, {-7, v}).r, 0, 1e-3);
  EXPECT_NEAR(cache.lookup(mirror, {1.125f, v}).r, 3, 1e-3);
  EXPECT_NEAR(cache.lookup(mirror, {1.375f, v}).r, 2, 1e-3);
}

TEST(TextureCache, DecodesSrgbOnlyWhereTold) {
  const test::ScratchFolder folder;
  Image image(2, 2, 3);
  for (int i = 0; i < 4; ++i) image.set_rgb(i % 2, i / 2, {0.2f, 0.5f, 1.0f});
  ASSERT_TRUE(write_image(folder / "t.png", image).ok());
  TextureCache cache;
  const int coded = cache.open(folder / "t.png", false, TextureWrap::kRepeat).value();
  const int linear = cache.open(folder / "t.png", true, TextureWrap::kRepeat).value();
  const Rgb a = cache.lookup(coded, {0.3f, 0.6f}), b = cache.lookup(linear, {0.3f, 0.6f});
  EXPECT_NEAR(a.r, linear_to_srgb(0.2f), 0.5 / 255);
  EXPECT_NEAR(a.g, linear_to_srgb(0.5f), 0.5 / 255);
  EXPECT_NEAR(b.r, 0.2, 0.005);
  EXPECT_NEAR(b.g, 0.5, 0.005);
  EXPECT_NEAR(b.b, 1, 1e-5);
}

TEST(TextureCache, GrayIsThreeTimesItself) {
  const test::ScratchFolder folder;
  Image image(2, 2, 1);
  for (float& v : image.data()) v = 0.75f;
  ASSERT_TRUE(write_image(folder / "t.exr", image).ok());
  TextureCache cache;
  const int handle = cache.open(folder / "t.exr", false, TextureWrap::kRepeat).value();
  const Rgb c = cache.lookup(handle, {0.4f, 0.4f});
  EXPECT_EQ(c, Rgb(0.75f));
}

TEST(TextureCache, AlphaDoesNotDarken) {
  const test::ScratchFolder folder;
  Image image(2, 2, 4);
  for (int i = 0; i < 16; ++i) image.data()[static_cast<size_t>(i)] = i % 4 == 3 ? 0.5f : 1.0f;
  ASSERT_TRUE(write_image(folder / "t.png", image).ok());
  TextureCache cache;
  const int handle = cache.open(folder / "t.png", true, TextureWrap::kRepeat).value();
  EXPECT_NEAR(cache.lookup(handle, {0.4f, 0.4f}).g, 1, 0.01);
}

TEST(TextureCache, ErrorsNameTheFile) {
  const test::ScratchFolder folder;
  TextureCache cache;
  const std::filesystem::path missing = folder / "none.png";
  EXPECT_EQ(cache.open(missing, true, TextureWrap::kRepeat).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(cache.open(missing, true, TextureWrap::kRepeat).error().where, missing.string());
  const Bytes text{'n', 'o', 't', ' ', 'i', 't'};
  ASSERT_TRUE(write_file_atomic(folder / "text.png", text).ok());
  EXPECT_EQ(cache.open(folder / "text.png", true, TextureWrap::kRepeat).error().code,
            ErrorCode::kInvalid);
}

TEST(TextureCache, WildCoordinatesAreHarmless) {
  const test::ScratchFolder folder;
  ASSERT_TRUE(write_image(folder / "t.exr", board()).ok());
  TextureCache cache;
  const int handle = cache.open(folder / "t.exr", false, TextureWrap::kRepeat).value();
  const float inf = std::numeric_limits<float>::infinity();
  for (const float u : {std::nanf(""), inf, -inf, 1e9f, -1e9f, 3e38f})
    EXPECT_TRUE(is_finite(cache.lookup(handle, {u, 0.5f}))) << u;
}

TEST(TextureCache, ManyThreadsSeeTheSameTexels) {
  const test::ScratchFolder folder;
  Image image(256, 256, 3);
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 256; ++x)
      image.set_rgb(x, y, {static_cast<float>(x), static_cast<float>(y), 0});
  ASSERT_TRUE(write_image(folder / "t.exr", image).ok());
  TextureCache cache;
  const int handle = cache.open(folder / "t.exr", false, TextureWrap::kRepeat).value();
  std::vector<int> wrong(4, 0);
  std::vector<std::thread> threads;
  for (uint32_t t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      uint32_t state = t * 7919 + 1;
      for (int i = 0; i < 5000; ++i) {
        state = state * 1664525u + 1013904223u;
        const uint32_t x = state >> 24, y = (state >> 15) & 255;
        const Rgb c = cache.lookup(handle, {(static_cast<float>(x) + 0.5f) / 256,
                                            1 - (static_cast<float>(y) + 0.5f) / 256});
        if (std::abs(c.r - static_cast<float>(x)) > 0.05f ||
            std::abs(c.g - static_cast<float>(y)) > 0.05f)
          ++wrong[t];
      }
    });
  for (std::thread& t : threads) t.join();
  EXPECT_EQ(wrong, std::vector<int>(4, 0));
}

}  // namespace
}  // namespace qray
