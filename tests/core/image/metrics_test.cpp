#include "core/image/metrics.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

namespace qray {
namespace {

Image uniform(int width, int height, Rgb c) {
  Image image(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) image.set_rgb(x, y, c);
  return image;
}

TEST(Metrics, IdenticalPicturesDoNotDiffer) {
  const Image image = uniform(20, 10, {0.3f, 4.0f, 0.0f});
  const ImageDifference d = image_difference(image, image).value();
  EXPECT_EQ(d.relmse, 0);
  EXPECT_EQ(d.relmse_trimmed, 0);
  EXPECT_EQ(d.flip, 0);
  EXPECT_EQ(d.mean_ratio, 1);
  EXPECT_EQ(d.max_abs, 0);
}

TEST(Metrics, RelmseByHand) {
  // Channels .5 against 1, 0 against 0, 2.1 against 2: .25/1.01, 0, .01/4.01.
  const ImageDifference d =
      image_difference(uniform(8, 8, {0.5f, 0, 2.1f}), uniform(8, 8, {1, 0, 2})).value();
  EXPECT_NEAR(d.relmse, (0.25 / 1.01 + 0.01 / 4.01) / 3, 1e-6);
  EXPECT_NEAR(d.max_abs, 0.5, 1e-6);
  EXPECT_NEAR(d.mean_ratio, luminance({0.5f, 0, 2.1f}) / luminance({1, 0, 2}), 1e-5);
}

TEST(Metrics, TrimmingDropsTheThousandthOfPixelsThatIsWorst) {
  const Image reference = uniform(50, 40, Rgb{1});  // 2000 pixels: 2 are dropped
  Image picture = uniform(50, 40, Rgb{1.1f});
  picture.set_rgb(3, 3, Rgb{1000});
  picture.set_rgb(30, 20, Rgb{500});
  const double usual = 0.1 * 0.1 / 1.01;
  const ImageDifference two = image_difference(picture, reference).value();
  EXPECT_NEAR(two.relmse_trimmed, usual, 1e-5);
  EXPECT_GT(two.relmse, 500);
  picture.set_rgb(7, 8, Rgb{3});
  const ImageDifference three = image_difference(picture, reference).value();
  EXPECT_NEAR(three.relmse_trimmed, usual + (4 / 1.01 - usual) / 1998, 1e-5);
}

TEST(Metrics, MeanRatioOfBlackReferences) {
  const Image black = uniform(4, 4, {}), gray = uniform(4, 4, Rgb{0.5f});
  EXPECT_EQ(image_difference(black, black).value().mean_ratio, 1);
  EXPECT_EQ(image_difference(gray, black).value().mean_ratio,
            std::numeric_limits<double>::infinity());
}

TEST(Metrics, ErrorsNameWhatIsWrong) {
  const Image good = uniform(4, 4, Rgb{0.5f});
  const Result<ImageDifference> size = image_difference(uniform(4, 5, Rgb{0.5f}), good);
  ASSERT_FALSE(size.ok());
  EXPECT_NE(size.error().message.find("4x5"), std::string::npos);
  EXPECT_NE(size.error().message.find("4x4"), std::string::npos);
  EXPECT_EQ(image_difference(Image(4, 4, 1), good).error().where, "picture");
  EXPECT_EQ(image_difference(good, Image(4, 4, 4)).error().where, "reference");
  Image bad = good;
  bad.at(2, 1, 0) = std::nanf("");
  EXPECT_NE(image_difference(bad, good).error().message.find("(2, 1)"), std::string::npos);
}

// The patterns of the reference values below; x, y in pixels.
using Pattern = std::function<Vec3(double x, double y)>;
Image draw(const Pattern& pattern) {
  Image image(61, 47, 3);
  for (int y = 0; y < 47; ++y)
    for (int x = 0; x < 61; ++x) {
      const Vec3 c = pattern(x, y);
      image.set_rgb(x, y, {c.x, c.y, c.z});
    }
  return image;
}
Vec3 wave(double x, double y) {
  return {static_cast<float>(0.5 + 0.4 * std::sin(0.31 * x + 0.11 * y)),
          static_cast<float>(0.5 + 0.4 * std::sin(0.05 * x - 0.23 * y + 1)),
          static_cast<float>(0.3 + 0.25 * std::cos(0.17 * x + 0.29 * y + 2))};
}
Vec3 shifted(double x, double y) {
  const Vec3 c = wave(x, y);
  return {wave(x + 2, y).x, c.y, c.z * 0.8f};
}
Vec3 noise(double x, double y) {
  const uint64_t n =
      (static_cast<uint64_t>(x) * 73856093 ^ static_cast<uint64_t>(y) * 19349663) % 1000;
  const float add = static_cast<float>((static_cast<double>(n) / 1000 - 0.5) * 0.4);
  return max(min(wave(x, y) + Vec3{add, add, add}, {1, 1, 1}), {0, 0, 0});
}
Vec3 dots(double x, double y) {
  const bool dot = static_cast<int>(x) % 13 == 4 && static_cast<int>(y) % 11 == 7;
  return dot ? Vec3{1, 1, 1} : wave(x, y);
}
Vec3 board(double x, double y) {
  const float m = static_cast<float>((static_cast<int>(x) / 6 + static_cast<int>(y) / 5) % 2);
  return {m * 0.9f, m * 0.2f + 0.1f, 1 - m * 0.7f};
}

double mean_value(const Image& map) {
  double sum = 0;
  for (float v : map.data()) sum += v;
  return sum / static_cast<double>(map.data().size());
}

// Reference: the authors' own evaluator, Python package flip-evaluator 1.7,
// evaluate(wave, pattern, "LDR", inputsRGB=False, applyMagma=False, parameters={"ppd": ...}).
TEST(Flip, AgreesWithItsAuthorsProgram) {
  struct Case {
    const char* name;
    Pattern pattern;
    float pixels_per_degree;
    double mean, middle, corner;  // over the picture, at (30, 20), at (0, 0)
  };
  const Case cases[] = {{"shifted", shifted, 67, 0.358262, 0.379723, 0.361303},
                        {"noise", noise, 67, 0.148488, 0.188762, 0.474830},
                        {"dots", dots, 67, 0.036559, 0.160192, 0.002483},
                        {"board", board, 67, 0.903435, 0.691859, 0.986079},
                        {"board", board, 30, 0.893776, 0.687263, 0.986152}};
  for (const Case& c : cases) {
    const Image map = flip_map(draw(c.pattern), draw(wave), c.pixels_per_degree);
    EXPECT_NEAR(mean_value(map), c.mean, 2e-5) << c.name;
    EXPECT_NEAR(map.at(30, 20, 0), c.middle, 1e-4) << c.name;
    EXPECT_NEAR(map.at(0, 0, 0), c.corner, 1e-4) << c.name;
  }
}

TEST(Flip, UniformPicturesByHand) {
  const auto flip = [](Rgb a, Rgb b) {
    return mean_value(flip_map(uniform(24, 24, a), uniform(24, 24, b)));
  };
  // Green to blue is the largest difference there is.
  EXPECT_NEAR(flip({0, 1, 0}, {0, 0, 1}), 1, 1e-4);
  // Grays have no chroma: the difference is |L1 - L2|^0.7, remapped (the paper's eq. 9).
  const auto lightness = [](double y) { return 116 * std::cbrt(y) - 16; };
  const auto hunt = [&](double l, double a, double b) {
    return Vec3{static_cast<float>(l), static_cast<float>(l * a / 100),
                static_cast<float>(l * b / 100)};
  };
  // CIELAB of the sRGB primaries (D65), published: green 87.737 -86.185 83.181, blue 32.297 79.188
  // -107.860.
  const Vec3 green = hunt(87.737, -86.185, 83.181), blue = hunt(32.297, 79.188, -107.860);
  const double largest =
      std::pow(std::abs(green.x - blue.x) + std::hypot(green.y - blue.y, green.z - blue.z), 0.7);
  const double gray = std::pow(lightness(0.25) - lightness(0.2), 0.7) * 0.95 / (0.4 * largest);
  EXPECT_NEAR(flip(Rgb{0.25f}, Rgb{0.2f}), gray, 2e-4);
  const double white = 0.95 + (std::pow(100, 0.7) - 0.4 * largest) / (0.6 * largest) * 0.05;
  EXPECT_NEAR(flip(Rgb{1}, Rgb{0}), white, 2e-4);
  EXPECT_NEAR(flip(Rgb{50}, Rgb{-3}), white, 2e-4);  // clamped
}

TEST(Flip, IsSymmetric) {
  const Image ab = flip_map(draw(noise), draw(board)), ba = flip_map(draw(board), draw(noise));
  for (size_t i = 0; i < ab.data().size(); ++i) EXPECT_EQ(ab.data()[i], ba.data()[i]);
}

}  // namespace
}  // namespace qray
