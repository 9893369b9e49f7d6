#include "core/image/difference_map.h"

#include <gtest/gtest.h>

#include "core/image/false_color.h"

namespace qray {
namespace {

Image uniform(Rgb c) {
  Image image(2, 1, 3);
  image.set_rgb(0, 0, c);
  image.set_rgb(1, 0, c);
  return image;
}

void expect_same(Rgb a, Rgb b) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], 1e-4);
}

TEST(ErrorMap, ScaleIsLogarithmicAndCutOff) {
  const Image black = uniform(Rgb{0.0f});
  // On black the error is x^2 / 0.01.
  const auto color_of = [&](double error) {
    return error_map(uniform(Rgb{static_cast<float>(std::sqrt(error * 0.01))}), black).rgb(1, 0);
  };
  expect_same(color_of(0), viridis(0));
  expect_same(color_of(1e-7), viridis(0));
  expect_same(color_of(1e-3), viridis(0.25f));
  expect_same(color_of(1e-2), viridis(0.5f));
  expect_same(color_of(1e6), viridis(1));
}

TEST(ErrorMap, IsRelativeToTheReference) {
  // (.5^2 / 4.01) / 3, one channel of three.
  const Rgb color = error_map(uniform({2.5f, 2, 2}), uniform(Rgb{2.0f})).rgb(0, 0);
  const double error = 0.25 / 4.01 / 3;
  expect_same(color, viridis(static_cast<float>((std::log10(error) + 4) / 4)));
}

TEST(SignedMap, IsRedWhereThePictureIsBrighter) {
  Image a = uniform(Rgb{1.0f}), b = uniform(Rgb{1.0f});
  a.set_rgb(0, 0, Rgb{2.0f});  // means 1.5 and 1: half of .8 above
  const Image map = signed_map(a, b), swapped = signed_map(b, a);
  expect_same(map.rgb(0, 0), diverging(0.8f));
  expect_same(map.rgb(1, 0), diverging(0));
  expect_same(swapped.rgb(0, 0), diverging(-0.8f));
  EXPECT_GT(map.rgb(0, 0).r, 2 * map.rgb(0, 0).b);
  EXPECT_GT(swapped.rgb(0, 0).b, 2 * swapped.rgb(0, 0).r);
  expect_same(signed_map(uniform(Rgb{0.0f}), uniform(Rgb{0.0f})).rgb(0, 0), diverging(0));
}

TEST(FlipMap, IsDarkWherePicturesAreEqual) {
  const Image same = flip_false_color(uniform(Rgb{0.5f}), uniform(Rgb{0.5f}));
  const Image other = flip_false_color(uniform(Rgb{1.0f}), uniform(Rgb{0.0f}));
  expect_same(same.rgb(0, 0), viridis(0));
  EXPECT_GT(luminance(other.rgb(0, 0)), 0.5f);
}

}  // namespace
}  // namespace qray
