// A thin film against what the wave theory says, wavelength by wavelength.
#include "core/bsdf/thin_film.h"

#include <gtest/gtest.h>

#include <complex>

#include "core/bsdf/ggx_albedo.h"

namespace qray {
namespace {

// The CIE 1931 observer by the fit of Wyman, Sloan and Shirley (2013), as red, green and blue.
std::array<double, 3> observer(double nm) {
  const auto lobe = [nm](double peak, double below, double above) {
    const double t = (nm - peak) * (nm < peak ? below : above);
    return std::exp(-0.5 * t * t);
  };
  const double x = 1.056 * lobe(599.8, 0.0264, 0.0323) + 0.362 * lobe(442.0, 0.0624, 0.0374) -
                   0.065 * lobe(501.1, 0.0490, 0.0382);
  const double y = 0.821 * lobe(568.8, 0.0213, 0.0247) + 0.286 * lobe(530.9, 0.0613, 0.0322);
  const double z = 1.217 * lobe(437.0, 0.0845, 0.0278) + 0.681 * lobe(459.0, 0.0385, 0.0725);
  return {3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
          -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
          0.0556434 * x - 0.2040259 * y + 1.0572252 * z};
}

// Airy's sum of all that comes back, head on: real indices 1, `film`, `base`.
double airy(double film, double base, double thickness_nm, double wavelength_nm) {
  const double top = (1 - film) / (1 + film), bottom = (film - base) / (film + base);
  const std::complex<double> late =
      std::polar(1.0, 4 * std::numbers::pi * film * thickness_nm / wavelength_nm);
  return std::norm((top + bottom * late) / (1.0 + top * bottom * late));
}

TEST(ThinFilm, HasTheColoursOfTheWaveTheory) {
  for (const double film_ior : {1.33, 1.8})
    for (const double base_ior : {1.2, 1.5, 3.0})
      for (const double nm : {0.0, 100.0, 250.0, 400.0, 600.0, 1200.0}) {
        std::array<double, 3> sum{}, white{};
        for (double wavelength = 380; wavelength <= 730; wavelength += 1) {
          const double share = airy(film_ior, base_ior, nm, wavelength);
          const std::array<double, 3> rgb = observer(wavelength);
          for (size_t i = 0; i < 3; ++i) {
            sum[i] += share * rgb[i];
            white[i] += rgb[i];
          }
        }
        const float f0 = static_cast<float>(std::pow((base_ior - 1) / (base_ior + 1), 2));
        const Rgb film =
            ThinFilm(static_cast<float>(film_ior), static_cast<float>(nm)).reflectance(Rgb{f0}, 1);
        for (int i = 0; i < 3; ++i) {
          const auto at = static_cast<size_t>(i);
          EXPECT_NEAR(film[i], std::clamp(sum[at] / white[at], 0.0, 1.0), 0.025)
              << "channel " << i << " film " << film_ior << " base " << base_ior << " " << nm;
        }
      }
}

TEST(ThinFilm, OfNoThicknessReflectsAsWithout) {
  const ThinFilm none(1.5f, 0);
  for (const float cosine : {1.0f, 0.7f, 0.3f, 0.05f})
    for (const float f0 : {0.02f, 0.3f, 0.9f})
      EXPECT_NEAR(none.reflectance(Rgb{f0}, cosine).g, lerp(schlick_weight(cosine), f0, 1.0f),
                  0.01f)
          << cosine << " " << f0;
  EXPECT_NEAR(none.mean_f0(Rgb{0.3f}).g, 0.3f, 0.01f);
}

TEST(ThinFilm, ReflectsAllAtTheHorizonAndNothingElseThanAShare) {
  for (float nm = 0; nm < 1500; nm += 37)
    for (const float ior : {1.0f, 1.3f, 2.5f}) {
      const ThinFilm film(ior, nm);
      EXPECT_NEAR(film.reflectance(Rgb{0.04f}, 0).g, 1, 0.02f) << nm << " " << ior;
      for (float cosine = 0; cosine <= 1; cosine += 0.05f)
        for (const float share : {film.reflectance({0.0f, 0.5f, 1.0f}, cosine).r,
                                  film.reflectance({0.0f, 0.5f, 1.0f}, cosine).b}) {
          EXPECT_GE(share, 0);
          EXPECT_LE(share, 1);
        }
    }
}

}  // namespace
}  // namespace qray
