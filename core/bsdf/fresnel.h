// Reflectance of a flat boundary for unpolarised light (Born and Wolf, section 1.5;
// pbrt-v4, 9.3.5). Cosines are of the angle to the (micro)normal, on the incident side, in [0, 1].
// Any thread.
#pragma once

#include "core/math/vec.h"

namespace qray {

// `eta`: index of the far side over that of the near side. `cos_t`: of the refracted direction, 0
// under total internal reflection.
struct DielectricFresnel {
  float reflectance;
  float cos_t;
};
inline DielectricFresnel fresnel_dielectric(float cos_i, float eta) {
  cos_i = std::clamp(cos_i, 0.0f, 1.0f);
  const float sin2_t = (1 - sqr(cos_i)) / sqr(eta);
  if (sin2_t >= 1) return {1, 0};
  const float cos_t = std::sqrt(1 - sin2_t);
  const float parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
  const float perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
  return {0.5f * (sqr(parallel) + sqr(perpendicular)), cos_t};
}

// A metal of index eta + i k, seen from vacuum.
inline float fresnel_conductor(float cos_i, float eta, float k) {
  cos_i = std::clamp(cos_i, 0.0f, 1.0f);
  const float cos2 = sqr(cos_i), sin2 = 1 - cos2;
  // a^2 + b^2 = |eta^2 - sin^2| and a = its root's real part.
  const float t = sqr(eta) - sqr(k) - sin2;
  const float modulus = std::sqrt(sqr(t) + 4 * sqr(eta * k));
  const float a = std::sqrt(std::max(0.0f, 0.5f * (modulus + t)));
  const float perpendicular = (modulus + cos2 - 2 * a * cos_i) / (modulus + cos2 + 2 * a * cos_i);
  const float s = cos2 * modulus + sqr(sin2), d = 2 * a * cos_i * sin2;
  const float parallel = s + d > 0 ? perpendicular * (s - d) / (s + d) : perpendicular;
  return 0.5f * (parallel + perpendicular);
}

// Mean of fresnel_dielectric over a diffuse field of light on the near side, 2 int F mu dmu.
inline float mean_fresnel_dielectric(float eta) {
  constexpr int kSteps = 1024;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const float mu = (static_cast<float>(i) + 0.5f) / kSteps;
    sum += static_cast<double>(fresnel_dielectric(mu, eta).reflectance) * mu;
  }
  return static_cast<float>(2 * sum / kSteps);
}

}  // namespace qray
