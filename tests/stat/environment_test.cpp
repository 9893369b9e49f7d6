// Light from a picture of the sky: the density is the picture's, poles and seams included, and
// surfaces are as bright as the integral over the picture says.
#include <gtest/gtest.h>
#include <malloc.h>

#include <filesystem>

#include "core/image/image_io.h"
#include "core/math/warp.h"
#include "tests/support/chi2.h"
#include "tests/support/places.h"
#include "tests/support/render.h"
#include "tests/support/stats.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

// Some texels are much brighter than most.
Image noise(int width, int height, uint64_t seed) {
  Image image(width, height, 3);
  test::Random random(seed);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      image.set_rgb(x, y, std::pow(random.next(), 4.0f) * Rgb{1, 0.9f, 1.1f});
  return image;
}

Image even_noise(int width, int height) {
  Image image(width, height, 3);
  test::Random random(4);
  for (float& v : image.data()) v = 0.5f + random.next();
  return image;
}

// Of several texels a tile: smooth but for stripes of noise, with a sun.
Image large_sky(int width, int height) {
  Image image(width, height, 3);
  test::Random random(6);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const float level = 1 + 0.5f * std::sin(0.01f * static_cast<float>(x + 2 * y));
      image.set_rgb(x, y, Rgb{y / 40 % 3 == 0 ? 2 * random.next() : level});
    }
  for (int x = 301; x < 304; ++x) image.set_rgb(x, 130, Rgb{3000});
  return image;
}

Environment with_image(Image image) {
  Environment environment;
  environment.radiance = {1, 0.9f, 0.8f};
  environment.image = std::move(image);
  environment.to_world = Mat3{{Vec3{0.6f, 0, -0.8f}, Vec3{0.8f, 0, 0.6f}, Vec3{0, 1, 0}}};
  return environment;
}

// Dark halves, a bright texel at either pole, at the seam, and one that outshines them.
std::vector<Environment> environments() {
  std::vector<Environment> all;
  all.push_back(with_image(noise(16, 8, 1)));
  Image half = noise(16, 8, 2);
  for (int x = 0; x < 16; ++x)
    for (int y = 4; y < 8; ++y) half.set_rgb(x, y, {});
  half.set_rgb(3, 0, Rgb{50});
  half.set_rgb(0, 2, Rgb{30});
  all.push_back(with_image(half));
  Image south(8, 4, 3);
  south.set_rgb(5, 3, Rgb{1});
  all.push_back(with_image(south));
  all.push_back(with_image(noise(2, 1, 3)));
  return all;
}

TEST(EnvironmentLight, DirectionsFollowTheDensity) {
  int i = 0;
  for (const Environment& environment : environments()) {
    const EnvironmentLight light(environment);
    test::Chi2Options options;
    options.tolerance = 1e-6;
    const test::Chi2 result = test::chi2_sphere(
        [&](test::Random& random) -> std::optional<Vec3> {
          const EnvironmentLight::Sample s = light.sample(random.next_2d());
          EXPECT_NEAR(s.pdf_w / light.pdf_w(s.wi), 1, 0.01) << i;
          return s.wi;
        },
        [&](Vec3 wi) { return light.pdf_w(wi); }, options);
    EXPECT_GT(result.p_value, test::significance(5)) << i << "\n" << result.table;
    EXPECT_NEAR(result.integral, 1, 2e-3) << i;
    ++i;
  }
}

// Of a picture with tiles, counted in blocks of texels. The density times the sine is linear or
// constant in each quarter of a texel: the middle's is its mean.
TEST(EnvironmentLight, DirectionsInALargePictureFollowTheDensity) {
  constexpr int kWidth = 1010, kHeight = 505, kSamples = 1'000'000;
  constexpr size_t kColumns = 101, kRows = 101;
  const Environment environment = with_image(large_sky(kWidth, kHeight));
  const EnvironmentLight light(environment);
  const auto bin = [](double u, double v) {
    return static_cast<size_t>(v * kRows) * kColumns + static_cast<size_t>(u * kColumns);
  };
  std::vector<double> expected(kColumns * kRows), observed(kColumns * kRows);
  double integral = 0;
  for (int y = 0; y < 2 * kHeight; ++y)
    for (int x = 0; x < 2 * kWidth; ++x) {
      const double u = (x + 0.5) / (2 * kWidth), v = (y + 0.5) / (2 * kHeight);
      const double theta = M_PI * v, phi = 2 * M_PI * (u - 0.5), sine = std::sin(theta);
      const Vec3 d{static_cast<float>(sine * std::sin(phi)), static_cast<float>(std::cos(theta)),
                   static_cast<float>(-sine * std::cos(phi))};
      const double share = double{light.pdf_w(environment.to_world * d)} * sine * M_PI * M_PI /
                           (2.0 * kWidth * kHeight);
      expected[bin(u, v)] += share * kSamples;
      integral += share;
    }
  EXPECT_NEAR(integral, 1, 1e-4);
  test::Random random(11);
  for (int i = 0; i < kSamples; ++i) {
    const EnvironmentLight::Sample s = light.sample(random.next_2d());
    const Vec3 d = environment.to_world.transposed() * s.wi;
    const double u = 0.5 + std::atan2(d.x, -d.z) / (2 * M_PI);
    const double v = std::atan2(std::hypot(d.x, d.z), d.y) / M_PI;
    ++observed[bin(std::min(u, 0.999999), std::min(v, 0.999999))];
  }
  const test::Chi2 result = test::chi2_counts(observed, expected);
  EXPECT_GT(result.p_value, test::significance(1)) << result.table;
}

// What lies in front of a surface is drawn as ever, most of what lies behind it is left out.
TEST(EnvironmentLight, DirectionsBehindASurfaceAreLeftOut) {
  std::vector<Environment> all = environments();
  all.push_back(with_image(large_sky(1010, 505)));
  test::Random random(12);
  for (const Environment& environment : all) {
    const EnvironmentLight light(environment);
    if (light.even()) continue;
    const bool many_tiles = environment.image.width() > 256;
    int behind = 0, left_out = 0;
    for (int i = 0; i < 20000; ++i) {
      const Vec3 normal = square_to_uniform_sphere(random.next_2d());
      const Vec2 u = random.next_2d();
      const EnvironmentLight::Sample free = light.sample(u), s = light.sample(u, normal);
      if (free.pdf_w > 0 && dot(free.wi, normal) < 0) ++behind, left_out += s.pdf_w == 0 ? 1 : 0;
      if (s.pdf_w == 0 && dot(free.wi, normal) < 0) continue;
      ASSERT_EQ(s.wi, free.wi);
      ASSERT_EQ(s.pdf_w, free.pdf_w);
    }
    if (many_tiles) {
      EXPECT_GT(left_out, 0.9 * behind);
    }
  }
}

// No direction is so unlikely for its light that it becomes a firefly: what this density leaves out
// is no more than the mean, which directions drawn from everywhere find.
TEST(EnvironmentLight, NoLightIsUnlikely) {
  std::vector<Environment> all = environments();
  all.push_back(with_image(large_sky(1010, 505)));
  all.push_back(with_image(even_noise(16, 8)));
  for (const Environment& environment : all) {
    const EnvironmentLight light(environment);
    test::Random random(5);
    for (int i = 0; i < 100'000; ++i) {
      Vec3 wi = square_to_uniform_sphere(random.next_2d());
      if (i % 2) {  // close to the poles
        const float r = 1e-6f + 1e-4f * random.next();
        const Vec3 local{r, i % 4 == 1 ? std::sqrt(1 - r * r) : -std::sqrt(1 - r * r), 0};
        wi = environment.to_world * local;
      }
      const Rgb radiance = light.radiance(wi) / environment.radiance;
      const double mean = double{light.mean_luminance() / luminance(environment.radiance)};
      const double drawn = 4 * double{kPi} * double{light.pdf_w(wi)};
      ASSERT_LE(luminance(radiance), 3.01 * mean * (1 + drawn) + 1e-6);
    }
  }
}

TEST(EnvironmentLight, AnEvenSkyIsLeftToPathsThatLeaveTheScene) {
  Image black(8, 4, 3);
  for (const Image& image : {Image(), even_noise(16, 8), black}) {
    const Environment environment = with_image(image);
    const EnvironmentLight light(environment);
    EXPECT_TRUE(light.even());
    EXPECT_EQ(light.at({0, 1, 0}).pdf_w, 0);
    EXPECT_EQ(light.at({0, 1, 0}).radiance, light.radiance({0, 1, 0}));
    Scene scene;
    test::add_box(scene, test::add_material(scene, Rgb{0.5f}), {-1, -1, -1}, {1, 1, 1}, false);
    scene.environment = environment;
    const auto prepared = test::prepare(scene);
    EXPECT_FALSE(prepared->lights.empty()) << "it is not left out";
    EXPECT_FALSE(prepared->lights.connects());
  }
  EXPECT_FALSE(EnvironmentLight(with_image(noise(16, 8, 1))).even());
}

size_t allocated_bytes() {
  const struct mallinfo2 info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

TEST(EnvironmentLight, ALargePictureCostsFourBytesATexelMore) {
  constexpr int kWidth = 4096, kHeight = 2048;
  const Environment environment = with_image(noise(kWidth, kHeight, 4));
  const size_t before = allocated_bytes();
  const EnvironmentLight light(environment);
  EXPECT_LT(allocated_bytes() - before, size_t{kWidth} * kHeight * 4 + (1 << 20));
  EXPECT_FALSE(light.even());
  EXPECT_NEAR(light.mean_luminance(), 0.171, 0.005);  // of the noise times the colour
}

struct Faces {
  std::array<Vec3, 6> normals{Vec3{1, 0, 0},  Vec3{-1, 0, 0}, Vec3{0, 1, 0},
                              Vec3{0, -1, 0}, Vec3{0, 0, 1},  Vec3{0, 0, -1}};
  std::array<double, 6> irradiance{};
};

// By the midpoint rule, exact for what is linear between texels' centres but for sine and cosine.
Faces integrate(const Environment& environment) {
  const EnvironmentLight light(environment);
  const int w = 2 * environment.image.width(), h = 2 * environment.image.height();
  Faces faces;
  for (int y = 0; y < h; ++y) {
    const double theta = M_PI * (y + 0.5) / h;
    const double solid_angle = 2 * M_PI / w * M_PI / h * std::sin(theta);
    for (int x = 0; x < w; ++x) {
      const double phi = 2 * M_PI * ((x + 0.5) / w - 0.5);
      const Vec3 d{static_cast<float>(std::sin(theta) * std::sin(phi)),
                   static_cast<float>(std::cos(theta)),
                   static_cast<float>(-std::sin(theta) * std::cos(phi))};
      const Vec3 wi = environment.to_world * d;
      const double flux = luminance(light.radiance(wi)) * solid_angle;
      for (size_t i = 0; i < 6; ++i)
        faces.irradiance[i] += flux * std::max(0.0f, dot(wi, faces.normals[i]));
    }
  }
  return faces;
}

void expect_irradiance(const Environment& environment, const char* name) {
  const Faces faces = integrate(environment);
  for (size_t i = 0; i < 6; ++i) {
    Scene scene;
    scene.name = name;
    test::add_box(scene, test::add_material(scene, Rgb{1}), {-1, -1, -1}, {1, 1, 1}, false);
    scene.environment = environment;
    scene.camera.position = faces.normals[i] * 3;
    scene.camera.target = {0, 0, 0};
    scene.camera.up = std::abs(faces.normals[i].y) > 0.5f ? Vec3{0, 0, 1} : Vec3{0, 1, 0};
    scene.camera.vertical_fov_deg = 20;
    const auto prepared = test::prepare(scene);
    constexpr int kSide = 32;
    const Image image =
        test::render(*prepared, test::small_settings("none", kSide, 64, i + 1)).image;
    test::Moments pixels;
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) pixels.add(luminance(image.rgb(x, y)));
    const double expected = faces.irradiance[i] / M_PI;
    EXPECT_LT(std::abs(pixels.mean() - expected), 3 * pixels.standard_error() + 1e-4 * expected)
        << name << ", face " << i << ": " << pixels.mean() << " +- " << pixels.standard_error()
        << ", expected " << expected;
    EXPECT_LT(pixels.standard_error(), 0.01 * expected) << name << ", face " << i;
  }
}

TEST(EnvironmentLight, ABoxIsAsBrightAsTheIntegral) {
  expect_irradiance(with_image(noise(64, 32, 9)), "noise");
  expect_irradiance(with_image(even_noise(64, 32)), "even noise");
}

TEST(EnvironmentLight, RealSkiesAreAsBrightAsTheIntegral) {
  const std::filesystem::path folder = test::testdata_dir() / "hdri-dev";
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << folder << " is not there";
  for (const char* name : {"qwantani_afternoon_puresky_1k.hdr", "st_peters_square_night_1k.hdr"}) {
    Result<Image> image = read_image(folder / name, 1 << 24);
    ASSERT_TRUE(image.ok()) << image.error().text();
    expect_irradiance(with_image(std::move(image).value()), name);
  }
}

}  // namespace
}  // namespace qray
