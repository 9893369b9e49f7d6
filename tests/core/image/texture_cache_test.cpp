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
Texture texture(const std::filesystem::path& path, bool srgb, TextureWrap wrap) {
  Texture texture;
  texture.path = path;
  texture.srgb = srgb;
  texture.wrap_u = texture.wrap_v = wrap;
  return texture;
}
// The middle of a texel, row counted from the top.
Vec2 middle(int x, int y) {
  return {(static_cast<float>(x) + 0.5f) / 4, 1 - (static_cast<float>(y) + 0.5f) / 2};
}

TEST(TextureCache, VZeroIsTheBottomRow) {
  const test::ScratchFolder folder;
  ASSERT_TRUE(write_image(folder / "t.exr", board()).ok());
  TextureCache cache;
  const Result<int> handle = cache.open(texture(folder / "t.exr", false, TextureWrap::kRepeat));
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
  const int with = cache.open(texture(folder / "a.exr", true, TextureWrap::kRepeat)).value();
  const int without = cache.open(texture(folder / "t.exr", true, TextureWrap::kRepeat)).value();
  for (int x = 0; x < 4; ++x) {
    EXPECT_NEAR(cache.lookup_alpha(with, middle(x, 1)), 0.25f * static_cast<float>(x), 1e-4);
    EXPECT_EQ(cache.lookup_alpha(without, middle(x, 1)), 1.0f);
  }
  EXPECT_EQ(cache.texel(with).x, 0.25f);
  EXPECT_EQ(cache.texel(with).y, 0.5f);
  EXPECT_EQ(cache.lookup_alpha(with, Vec2{1e30f, 0}), 0.0f);
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
    const int handle = cache.open(texture(path, false, TextureWrap::kRepeat)).value();
    pool.run(64, [&](size_t, int) {
      EXPECT_NEAR(cache.lookup(handle, Vec2{0.4f, 0.6f}).g, value, 1e-3);
    });
  }
}

TEST(TextureCache, InterpolatesAndWraps) {
  const test::ScratchFolder folder;
  ASSERT_TRUE(write_image(folder / "t.exr", board()).ok());
  TextureCache cache;
  const auto open = [&](TextureWrap wrap) {
    return cache.open(texture(folder / "t.exr", false, wrap)).value();
  };
  const int repeat = open(TextureWrap::kRepeat), clamp = open(TextureWrap::kClamp),
            mirror = open(TextureWrap::kMirror);
  const float v = middle(0, 0).y;
  EXPECT_NEAR(cache.lookup(repeat, Vec2{0.5f, v}).r, 1.5, 1e-3);  // between texels 1 and 2
  EXPECT_NEAR(cache.lookup(repeat, Vec2{0.5f + 0.0625f, v}).r, 1.75, 1e-3);
  EXPECT_NEAR(cache.lookup(repeat, Vec2{0, v}).r, 1.5, 1e-3);  // texels 3 and 0
  EXPECT_NEAR(cache.lookup(repeat, Vec2{1.125f, v}).r, 0, 1e-3);
  EXPECT_NEAR(cache.lookup(clamp, Vec2{1.125f, v}).r, 3, 1e-3);
  EXPECT_NEAR(cache.lookup(clamp, Vec2{-7, v}).r, 0, 1e-3);
  EXPECT_NEAR(cache.lookup(mirror, Vec2{1.125f, v}).r, 3, 1e-3);
  EXPECT_NEAR(cache.lookup(mirror, Vec2{1.375f, v}).r, 2, 1e-3);
}

TEST(TextureCache, DecodesSrgbOnlyWhereTold) {
  const test::ScratchFolder folder;
  Image image(2, 2, 3);
  for (int i = 0; i < 4; ++i) image.set_rgb(i % 2, i / 2, {0.2f, 0.5f, 1.0f});
  ASSERT_TRUE(write_image(folder / "t.png", image).ok());
  TextureCache cache;
  const int coded = cache.open(texture(folder / "t.png", false, TextureWrap::kRepeat)).value();
  const int linear = cache.open(texture(folder / "t.png", true, TextureWrap::kRepeat)).value();
  const Rgb a = cache.lookup(coded, Vec2{0.3f, 0.6f}), b = cache.lookup(linear, Vec2{0.3f, 0.6f});
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
  const int handle = cache.open(texture(folder / "t.exr", false, TextureWrap::kRepeat)).value();
  const Rgb c = cache.lookup(handle, Vec2{0.4f, 0.4f});
  EXPECT_EQ(c, Rgb(0.75f));
}

TEST(TextureCache, AlphaDoesNotDarken) {
  const test::ScratchFolder folder;
  Image image(2, 2, 4);
  for (int i = 0; i < 16; ++i) image.data()[static_cast<size_t>(i)] = i % 4 == 3 ? 0.5f : 1.0f;
  ASSERT_TRUE(write_image(folder / "t.png", image).ok());
  TextureCache cache;
  const int handle = cache.open(texture(folder / "t.png", true, TextureWrap::kRepeat)).value();
  EXPECT_NEAR(cache.lookup(handle, Vec2{0.4f, 0.4f}).g, 1, 0.01);
}

TEST(TextureCache, ErrorsNameTheFile) {
  const test::ScratchFolder folder;
  TextureCache cache;
  const std::filesystem::path missing = folder / "none.png";
  EXPECT_EQ(cache.open(texture(missing, true, TextureWrap::kRepeat)).error().code,
            ErrorCode::kNotFound);
  EXPECT_EQ(cache.open(texture(missing, true, TextureWrap::kRepeat)).error().where,
            missing.string());
  const Bytes text{'n', 'o', 't', ' ', 'i', 't'};
  ASSERT_TRUE(write_file_atomic(folder / "text.png", text).ok());
  EXPECT_EQ(cache.open(texture(folder / "text.png", true, TextureWrap::kRepeat)).error().code,
            ErrorCode::kInvalid);
}

TEST(TextureCache, WildCoordinatesAreHarmless) {
  const test::ScratchFolder folder;
  ASSERT_TRUE(write_image(folder / "t.exr", board()).ok());
  TextureCache cache;
  const int handle = cache.open(texture(folder / "t.exr", false, TextureWrap::kRepeat)).value();
  const float inf = std::numeric_limits<float>::infinity();
  for (const float u : {std::nanf(""), inf, -inf, 1e9f, -1e9f, 3e38f})
    EXPECT_TRUE(is_finite(cache.lookup(handle, Vec2{u, 0.5f}))) << u;
}

TEST(TextureCache, ManyThreadsSeeTheSameTexels) {
  const test::ScratchFolder folder;
  Image image(256, 256, 3);
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 256; ++x)
      image.set_rgb(x, y, {static_cast<float>(x), static_cast<float>(y), 0});
  ASSERT_TRUE(write_image(folder / "t.exr", image).ok());
  TextureCache cache;
  const int handle = cache.open(texture(folder / "t.exr", false, TextureWrap::kRepeat)).value();
  std::vector<int> wrong(4, 0);
  std::vector<std::thread> threads;
  for (uint32_t t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      uint32_t state = t * 7919 + 1;
      for (int i = 0; i < 5000; ++i) {
        state = state * 1664525u + 1013904223u;
        const uint32_t x = state >> 24, y = (state >> 15) & 255;
        const Rgb c = cache.lookup(handle, Vec2{(static_cast<float>(x) + 0.5f) / 256,
                                                1 - (static_cast<float>(y) + 0.5f) / 256});
        if (std::abs(c.r - static_cast<float>(x)) > 0.05f ||
            std::abs(c.g - static_cast<float>(y)) > 0.05f)
          ++wrong[t];
      }
    });
  for (std::thread& t : threads) t.join();
  EXPECT_EQ(wrong, std::vector<int>(4, 0));
}

TEST(TextureCache, PicturesInMemoryAreTheSame) {
  const test::ScratchFolder folder;
  Image image(3, 2, 4);
  for (size_t i = 0; i < image.data().size(); ++i)
    image.data()[i] = static_cast<float>(i) / static_cast<float>(image.data().size());
  for (const char* name : {"t.png", "t.exr"}) {
    ASSERT_TRUE(write_image(folder / name, image).ok());
    Texture on_disk = texture(folder / name, false, TextureWrap::kRepeat), in_memory = on_disk;
    in_memory.path = "picture 7";
    in_memory.bytes = std::make_shared<Bytes>(read_file(folder / name, 1 << 20).value());
    TextureCache cache;
    const Result<int> a = cache.open(on_disk), b = cache.open(in_memory);
    ASSERT_TRUE(a.ok() && b.ok()) << b.error().text();
    for (int x = 0; x < 3; ++x) {
      const Vec2 uv{(static_cast<float>(x) + 0.6f) / 3, 0.4f};
      EXPECT_EQ(cache.lookup(a.value(), uv), cache.lookup(b.value(), uv)) << name;
      EXPECT_EQ(cache.lookup_alpha(a.value(), uv), cache.lookup_alpha(b.value(), uv)) << name;
      EXPECT_GT(cache.lookup_alpha(a.value(), uv), 0);
    }
  }
  Texture broken = texture("picture 8", false, TextureWrap::kRepeat);
  broken.bytes = std::make_shared<Bytes>(Bytes{0x89, 'P', 'N', 'G', 1, 2, 3});
  TextureCache cache;
  const Result<int> handle = cache.open(broken);
  ASSERT_FALSE(handle.ok());
  EXPECT_EQ(handle.error().where, "picture 8");
}

TEST(TextureCache, EachAxisWrapsItsOwnWay) {
  const test::ScratchFolder folder;
  ASSERT_TRUE(write_image(folder / "t.exr", board()).ok());
  TextureCache cache;
  Texture t = texture(folder / "t.exr", false, TextureWrap::kRepeat);
  t.wrap_v = TextureWrap::kClamp;
  const int handle = cache.open(t).value();
  const Vec2 at = middle(1, 0);
  EXPECT_EQ(cache.lookup(handle, Vec2{at.x + 3, at.y + 5}), (Rgb{1, 0, 0.5f}));
  EXPECT_EQ(cache.lookup(handle, Vec2{at.x - 2, at.y - 5}), (Rgb{1, 1, 0.5f}));
}

TEST(TextureCache, NearestTexelsAreSquares) {
  const test::ScratchFolder folder;
  ASSERT_TRUE(write_image(folder / "t.exr", board()).ok());
  TextureCache cache;
  Texture t = texture(folder / "t.exr", false, TextureWrap::kRepeat);
  t.nearest = true;
  const int handle = cache.open(t).value();
  for (const float u : {0.2501f, 0.4999f, 1.3f, -0.51f})
    EXPECT_EQ(cache.lookup(handle, Vec2{u, 0.9f}), (Rgb{1, 0, 0.5f})) << u;
}

TEST(TextureCache, UvsAreTransformed) {
  const test::ScratchFolder folder;
  ASSERT_TRUE(write_image(folder / "t.exr", board()).ok());
  TextureCache cache;
  Texture t = texture(folder / "t.exr", false, TextureWrap::kRepeat);
  const int plain = cache.open(t).value();
  t.uv_transform = {{0, 2, 0.25f}, {-1, 0, 0.5f}};
  const int turned = cache.open(t).value();
  const Vec2 uv{0.3f, 0.2f};
  EXPECT_EQ(cache.lookup(turned, uv), cache.lookup(plain, Vec2{2 * 0.2f + 0.25f, 0.5f - 0.3f}));
  // One more in u goes two texels down, one more in v eight to the right.
  EXPECT_FLOAT_EQ(cache.texel(turned).x, 1 / 2.0f);
  EXPECT_FLOAT_EQ(cache.texel(turned).y, 1 / 8.0f);
}

Image stripes(int width, int height) {
  Image image(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) image.set_rgb(x, y, x % 2 ? Rgb{1} : Rgb{});
  return image;
}

TEST(TextureCache, LevelsAreMeansOfLinearLight) {
  const test::ScratchFolder folder;
  for (const auto& [width, height] : {std::pair{256, 128}, {200, 37}, {1, 64}}) {
    Image image = stripes(width, height);
    if (width == 1) image = Image(1, 64, 3);
    ASSERT_TRUE(write_image(folder / "t.png", image).ok());
    TextureCache cache;
    const int handle = cache.open(texture(folder / "t.png", true, TextureWrap::kRepeat)).value();
    for (const float texels : {8.0f, 16.0f, 50.0f}) {
      const TexturePoint at({0.3f, 0.4f}, texels / static_cast<float>(std::min(width, height)));
      EXPECT_NEAR(cache.lookup(handle, at).g, width == 1 ? 0 : 0.5, 0.005)
          << width << " " << texels;
    }
  }
}

TEST(TextureCache, SmallPicturesAreReadAtOnce) {
  const test::ScratchFolder folder;
  ASSERT_TRUE(write_image(folder / "t.png", stripes(64, 64)).ok());
  const Texture t = texture(folder / "t.png", true, TextureWrap::kRepeat);
  TextureCache cache, large;
  for (TextureCache* c : {&cache, &large})
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(c->open(t).ok());
  large.read(2, 3 * 64 * 64 * 3);
  EXPECT_EQ(large.size_bytes(), 0u) << "with the coarser levels they are larger";
  cache.read(2);
  const size_t bytes = cache.size_bytes();
  EXPECT_NEAR(static_cast<double>(bytes), 3 * 64 * 64 * 3 * 4.0 / 3, 30);
  for (const float texels : {0.0f, 9.0f}) {
    const TexturePoint at({0.503f, 0.2f}, texels / 64);
    EXPECT_EQ(cache.lookup(1, at), large.lookup(1, at));
  }
  EXPECT_EQ(cache.size_bytes(), bytes);
}

// Every byte, from the least linear value that rounds to it.
TEST(TextureCache, CoarserLevelsRoundAsTheTransferCurveDoes) {
  const test::ScratchFolder folder;
  Image ramp(512, 2, 3);  // two texels of every byte
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 512; ++x) {
      const float v = srgb_to_linear(static_cast<float>(x / 2) / 255);
      ramp.set_rgb(x, y, Rgb{v});
    }
  ASSERT_TRUE(write_image(folder / "ramp.png", ramp).ok());
  TextureCache cache;
  const int handle = cache.open(texture(folder / "ramp.png", true, TextureWrap::kClamp)).value();
  for (int byte = 0; byte < 256; ++byte) {
    const TexturePoint at({(static_cast<float>(byte) + 0.5f) / 256, 0.5f}, 6.0f / 2);
    EXPECT_EQ(cache.lookup(handle, at).g, srgb_to_linear(static_cast<float>(byte) / 255)) << byte;
  }
}

TEST(TextureCache, OnlyTheLevelsAskedForCostMemory) {
  const test::ScratchFolder folder;
  constexpr int kSide = 1024;
  ASSERT_TRUE(write_image(folder / "t.png", stripes(kSide, kSide)).ok());
  const Texture t = texture(folder / "t.png", true, TextureWrap::kRepeat);
  TextureCache cache;
  const int handle = cache.open(t).value();
  EXPECT_EQ(cache.size_bytes(), 0u);
  const size_t whole = kSide * kSide * 3;
  const auto costs_about = [&](float texels) {
    cache.lookup(handle, TexturePoint({0.5f, 0.5f}, texels / kSide));
    return static_cast<double>(cache.size_bytes()) / static_cast<double>(whole);
  };
  EXPECT_NEAR(costs_about(64), 4.0 / 3 / 256, 1e-4);  // texels of 16
  EXPECT_NEAR(costs_about(600), 4.0 / 3 / 256, 1e-4);
  EXPECT_NEAR(costs_about(9), 4.0 / 3, 1e-3) << "a second time it is all read";

  // The same bits in whatever order levels were made.
  TextureCache other;
  other.open(t).value();
  for (const float texels : {0.0f, 5.0f, 9.0f, 64.0f, 600.0f}) {
    const TexturePoint at({0.503f, 0.2f}, texels / kSide);
    EXPECT_EQ(cache.lookup(handle, at), other.lookup(0, at)) << texels;
  }
}

TEST(TextureCache, TheLargestLoseTheirFinestLevelsOverTheLimit) {
  const test::ScratchFolder folder;
  ASSERT_TRUE(write_image(folder / "large.png", stripes(512, 512)).ok());
  ASSERT_TRUE(write_image(folder / "small.png", stripes(64, 64)).ok());
  TextureCache cache(300'000);
  const int large = cache.open(texture(folder / "large.png", true, TextureWrap::kRepeat)).value();
  const int small = cache.open(texture(folder / "small.png", true, TextureWrap::kRepeat)).value();
  EXPECT_NEAR(cache.lookup(large, Vec2{0.5f / 512, 0.5f}).r, 0.5, 0.005);  // two texels' mean
  EXPECT_EQ(cache.lookup(small, Vec2{0.5f / 64, 0.5f}).r, 0);
  EXPECT_LT(cache.size_bytes(), 300'000u);
}

}  // namespace
}  // namespace qray
