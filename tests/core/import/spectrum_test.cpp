#include "core/import/spectrum.h"

#include <gtest/gtest.h>

namespace qray {
namespace {

const std::vector<SpectrumPoint> kWhite = {{300, 1}, {900, 1}};

void expect_near_color(Rgb a, Rgb b, float relative) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], relative * b[i]) << i;
}

// The sRGB white is D65; equal energy has the chromaticity (1/3, 1/3).
TEST(Spectrum, WhiteIsTheIlluminant) {
  expect_near_color(spectrum_to_rgb(kWhite, SpectrumWeight::kD65), Rgb{1.0f}, 5e-4f);
  expect_near_color(spectrum_to_rgb(kWhite, SpectrumWeight::kEqualEnergy),
                    {1.2048f, 0.9483f, 0.9088f}, 1e-3f);
}

TEST(Spectrum, LuminanceIsLinear) {
  const Rgb once = spectrum_to_rgb({{500, 1}, {600, 1}}, SpectrumWeight::kEqualEnergy);
  const Rgb twice = spectrum_to_rgb({{500, 2}, {600, 2}}, SpectrumWeight::kEqualEnergy);
  expect_near_color(twice, once * 2, 1e-5f);
  EXPECT_EQ(spectrum_to_rgb({{500, 1}}, SpectrumWeight::kD65), Rgb{});
  EXPECT_EQ(spectrum_to_rgb({{100, 1}, {300, 1}}, SpectrumWeight::kD65), Rgb{});
}

TEST(Spectrum, NothingIsNegative) {
  const Rgb cyan = spectrum_to_rgb({{480, 0}, {500, 1}, {520, 0}}, SpectrumWeight::kEqualEnergy);
  EXPECT_EQ(cyan.r, 0);
  EXPECT_GT(cyan.g, 0);
}

// D65 is a phase of daylight; a body of its correlated colour temperature is a little greener.
TEST(Spectrum, BlackbodyOfDaylightIsNearlyWhite) {
  const Rgb day = blackbody_to_rgb(6504);
  EXPECT_NEAR(day.r / day.g, 1, 0.07);
  EXPECT_NEAR(day.b / day.g, 1, 0.07);
  const Rgb lamp = blackbody_to_rgb(2700);
  EXPECT_GT(lamp.r, 1.8f * lamp.g);
  EXPECT_GT(lamp.g, 1.8f * lamp.b);
  // Where the eye sees most, at 555 nm, 2 h c^2 / l^5 / (e^(h c / l k T) - 1) = 4.28e4 W / (m^2 sr
  // nm).
  EXPECT_NEAR(luminance(day), 4.2e4f, 0.1e4f);
}

}  // namespace
}  // namespace qray
