#include "core/chart/error_map.h"

#include <gtest/gtest.h>

#include "core/chart/names.h"
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

TEST(ChartNames, AreSafeInEveryFileSystem) {
  EXPECT_EQ(chart_file_name("huang:grid=12;nee=off"), "huang-grid-12-nee-off");
  EXPECT_EQ(chart_file_name("Cornell Box/../x"), "cornell-box-..-x");
  EXPECT_EQ(chart_picture("room", "huang:alpha=0.5", true), "room/huang-alpha-0.5-warm.png");
  EXPECT_EQ(chart_picture("room", "none", false), "room/none.png");
  EXPECT_EQ(chart_error_picture("room", "none", false), "room/none-error.png");
  EXPECT_EQ(chart_error_picture("room", "huang", true), "room/huang-warm-error.png");
  EXPECT_EQ(chart_reference_picture("room"), "room/reference.png");
}

}  // namespace
}  // namespace qray
