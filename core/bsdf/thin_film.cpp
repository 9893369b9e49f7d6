#include "core/bsdf/thin_film.h"

#include "core/bsdf/fresnel.h"
#include "core/bsdf/ggx_albedo.h"

namespace qray {
namespace {

float schlick(float f0, float cosine) { return lerp(schlick_weight(cosine), f0, 1.0f); }

// How the light's waves add up in red, green and blue, of white light 1, if they lag by a path of
// `nm` and by `shift`: the paper's fit of the observer's curves by Gaussians, transformed.
Rgb fringe(float nm, Rgb shift) {
  struct Gaussian {
    double height, position, variance;
  };
  constexpr Gaussian kX{5.4856e-13, 1.6810e6, 4.3278e9}, kX2{9.7470e-14, 2.2399e6, 4.5282e9},
      kY{4.4201e-13, 1.7953e6, 9.3046e9}, kZ{5.2481e-13, 2.2084e6, 6.6121e9};
  constexpr double kWhole = 1.0685e-7;
  const double phase = 2 * std::numbers::pi * static_cast<double>(nm) * 1e-9;
  const auto of = [&](const Gaussian& g, float lag) {
    return g.height * std::sqrt(2 * std::numbers::pi * g.variance) / kWhole *
           std::cos(g.position * phase + static_cast<double>(lag)) *
           std::exp(-g.variance * phase * phase);
  };
  const double x = of(kX, shift.r) + of(kX2, shift.r), y = of(kY, shift.g), z = of(kZ, shift.b);
  // Over the sums of the rows, which are what light of equal energy has.
  return {static_cast<float>((3.2404542 * x - 1.5371385 * y - 0.4985314 * z) / 1.2047843),
          static_cast<float>((-0.9692660 * x + 1.8760108 * y + 0.0415560 * z) / 0.9483008),
          static_cast<float>((0.0556434 * x - 0.2040259 * y + 1.0572252 * z) / 0.9088427)};
}

}  // namespace

// A film that vanishes becomes air, so that its colours come in without a step.
ThinFilm::ThinFilm(float ior, float thickness_nm) : thickness_nm_(thickness_nm) {
  const float t = std::clamp(thickness_nm / 0.03f, 0.0f, 1.0f);
  ior_ = lerp(t * t * (3 - 2 * t), 1.0f, ior);
}

Rgb ThinFilm::reflectance(Rgb f0, float cosine) const {
  const float sin2 = (1 - sqr(cosine)) / sqr(ior_);
  if (sin2 >= 1) return Rgb{1.0f};
  const float cos_film = std::sqrt(1 - sin2);
  const float top = fresnel_dielectric(cosine, ior_).reflectance, through = 1 - top;
  Rgb bottom, loop, late, shift;
  for (int i = 0; i < 3; ++i) {
    const float root = std::sqrt(std::clamp(f0[i], 0.0f, 0.9999f));
    const float base_ior = (1 + root) / (1 - root);
    bottom[i] = schlick(sqr((base_ior - ior_) / (base_ior + ior_)), cos_film);
    shift[i] = kPi + (base_ior < ior_ ? kPi : 0);  // above and below the film
    loop[i] = std::sqrt(std::clamp(top * bottom[i], 1e-5f, 0.9999f));
    late[i] = sqr(through) * bottom[i] / (1 - sqr(loop[i]));
  }
  // The mean of all wavelengths, and the first two orders of the fringes about it.
  Rgb sum = Rgb{top} + late, order = late - Rgb{through};
  const float path_nm = 2 * ior_ * thickness_nm_ * cos_film;
  for (int m = 1; m <= 2; ++m) {
    order *= loop;
    const float times = static_cast<float>(m);
    sum += order * fringe(times * path_nm, shift * times) * 2.0f;
  }
  for (int i = 0; i < 3; ++i) sum[i] = std::clamp(sum[i], 0.0f, 1.0f);
  return sum;
}

Rgb ThinFilm::mean_f0(Rgb f0) const {
  constexpr int kSteps = 4;  // over the cosine squared
  Rgb above{};
  float left = 0;
  for (int i = 0; i < kSteps; ++i) {
    const float cosine = std::sqrt((static_cast<float>(i) + 0.5f) / kSteps);
    const float grazing = schlick_weight(cosine);
    above += reflectance(f0, cosine) - Rgb{grazing};
    left += 1 - grazing;
  }
  for (int i = 0; i < 3; ++i) above[i] = std::clamp(above[i] / left, 0.0f, 1.0f);
  return above;
}

}  // namespace qray
