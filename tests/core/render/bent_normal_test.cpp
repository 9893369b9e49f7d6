#include "core/render/bent_normal.h"

#include <gtest/gtest.h>

#include "core/image/image_io.h"
#include "tests/support/near.h"
#include "tests/support/random.h"
#include "tests/support/scratch.h"

namespace qray {
namespace {

using test::expect_near;

// A unit square in the plane z = 0 whose uv are x and y, mirrored where asked for.
struct Chart {
  test::ScratchFolder folder;
  MaterialTextures textures;
  Material material;
  TriangleEdges edges{{1, 0, 0}, {0, 1, 0}, {1, 0}, {0, 1}};
  SurfacePoint surface{{}, {0, 0, 1}, {0, 0, 1}, Vec2{0.4f, 0.3f}};

  void open(const Image& image) {
    Texture texture;
    texture.path = folder / "t.exr";
    texture.srgb = false;
    EXPECT_TRUE(write_image(texture.path, image).ok());
    EXPECT_TRUE(textures.open({texture}, 1).ok());
  }
  Vec3 normal(Vec3 wo = {0, 0, 1}) const {
    return bent_normal(textures, material, edges, surface, normalize(wo));
  }
};
Image plain(Rgb texel) {
  Image image(4, 4, 3);
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x) image.set_rgb(x, y, texel);
  return image;
}

TEST(BentNormal, ImagesXPointsToUAndYToV) {
  const Vec3 n = normalize({0.3f, 0.2f, 0.9f});
  Chart chart;
  chart.open(plain({0.5f + n.x / 2, 0.5f + n.y / 2, 0.5f + n.z / 2}));
  chart.material.normal_map = TextureId(0);
  expect_near(chart.normal(), n, 1e-4f);
  chart.material.normal_scale = 0.5f;
  expect_near(chart.normal(), normalize({n.x / 2, n.y / 2, n.z}), 1e-4f);
  chart.material.normal_scale = 1;
  chart.edges.uv1 = {-1, 0};  // a mirrored chart
  expect_near(chart.normal(), {-n.x, n.y, n.z}, 1e-4f);
  chart.edges.uv1 = {0, 1};  // x and y exchanged
  chart.edges.uv2 = {1, 0};
  expect_near(chart.normal(), {n.y, n.x, n.z}, 1e-4f);
}

TEST(BentNormal, ARampLeansAgainstItsSlope) {
  // Heights rise by 0.1 texel values a texel of 1/16: slope 1.6 times the scale.
  Image image(16, 16, 3);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x) image.set_rgb(x, y, {0, 0.1f * static_cast<float>(x), 0});
  Chart chart;
  chart.open(image);
  chart.material.bump_map = {0.5f, TextureId(0), 1};
  expect_near(chart.normal(), normalize({-0.8f, 0, 1}), 2e-3f);
  chart.edges = {{2, 0, 0}, {0, 2, 0}, {1, 0}, {0, 1}};  // twice as wide: half as steep
  expect_near(chart.normal(), normalize({-0.4f, 0, 1}), 2e-3f);
  chart.edges = {{2, 0, 0}, {0, 2, 0}, {-1, 0}, {0, 1}};
  expect_near(chart.normal(), normalize({0.4f, 0, 1}), 2e-3f);
}

TEST(BentNormal, ATriangleWithoutAnAreaInUvStaysAsItIs) {
  Chart chart;
  chart.open(plain({0.9f, 0.5f, 0.7f}));
  chart.material.normal_map = TextureId(0);
  chart.edges.uv1 = chart.edges.uv2 = {};
  expect_near(chart.normal(), {0, 0, 1}, 1e-4f);
}

TEST(UvFrame, TurnsFromUTowardV) {
  const float turn = kPi / 6, cosine = std::cos(turn), sine = std::sin(turn);
  const auto frame = [turn](Vec2 uv1, Vec2 uv2) {
    return uv_frame({{2, 0, 0}, {0, 3, 0}, uv1, uv2}, {0, 0, 1}, turn);
  };
  expect_near(frame({1, 0}, {0, 1}).x, {cosine, sine, 0});
  expect_near(frame({1, 0}, {0, 1}).y, {-sine, cosine, 0});
  expect_near(frame({-1, 0}, {0, 1}).x, {-cosine, sine, 0});  // a mirrored chart
  expect_near(frame({0, 1}, {1, 0}).x, {sine, cosine, 0});    // u along y
  const Vec3 bent = normalize({0.3f, 0.1f, 1});
  const Frame about = uv_frame({{2, 0, 0}, {0, 3, 0}, {1, 0}, {0, 1}}, bent, 0);
  expect_near(about.z, bent);
  EXPECT_NEAR(dot(about.x, bent), 0, 1e-6f);
  EXPECT_GT(about.x.x, 0.95f);
  expect_near(frame({}, {}).x, Frame({0, 0, 1}).x);  // no uv directions
}

TEST(BentNormal, IsSeenAndMirrorsAboveTheSurface) {
  test::Random random(9);
  const auto direction = [&] {
    const Vec2 u = random.next_2d();
    const float z = 2 * u.x - 1, r = std::sqrt(1 - z * z), phi = 2 * kPi * u.y;
    return Vec3{r * std::cos(phi), r * std::sin(phi), z};
  };
  for (int i = 0; i < 20'000; ++i) {
    const Vec3 ng = direction(), wo = direction();
    Vec3 n = direction();
    if (dot(n, ng) < 0) n = -n;
    const Vec3 seen = seen_normal(n, ng, wo);
    const float side = dot(wo, ng) < 0 ? -1.0f : 1.0f;
    ASSERT_NEAR(length(seen), 1, 1e-4);
    ASSERT_GT(dot(seen, ng), 0);
    ASSERT_GT(dot(seen, wo) * side, 0);
    const Vec3 mirrored = seen * (2 * dot(seen, wo)) - wo;
    ASSERT_GT(dot(mirrored, ng) * side, -1e-4f);
    // One that is well seen is left alone.
    const Vec3 front = n * side, up = ng * side;
    if (dot(up, wo) > 1e-3f && dot(front, wo) > 0.02f &&
        dot(front * (2 * dot(front, wo)) - wo, up) > 0.02f) {
      expect_near(seen, n, 1e-6f);
    }
  }
}

}  // namespace
}  // namespace qray
