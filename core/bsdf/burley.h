// The diffuse part of Disney's model: Burley 2012, "Physically Based Shading at Disney",
// sections 5.3 (diffuse) and 5.6 (sheen). Not normalized: a white base returns 98 to 104 % of what
// arrives head on, by roughness, and 49 to 156 % of what grazes it.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/bsdf/ggx_albedo.h"
#include "core/math/vec.h"

namespace qray {

// f * pi, of a base and a sheen of albedo 1 each; o and i above the surface.
struct Burley {
  float diffuse, sheen;
  Burley(Vec3 o, Vec3 i, float roughness) {
    const float at_o = schlick_weight(o.z), at_i = schlick_weight(i.z);
    const float cos_d2 = 0.5f * (1 + dot(o, i));
    const float retro = 2 * roughness * cos_d2;
    diffuse =
        (1 - 0.5f * at_o) * (1 - 0.5f * at_i) + retro * (at_o + at_i + at_o * at_i * (retro - 1));
    sheen = kPi * schlick_weight(std::sqrt(std::max(cos_d2, 0.0f)));
  }
  // Share of light from cosine z that the base scatters: the integral of `diffuse` above.
  static float albedo(float z, float roughness) {
    const float f = schlick_weight(z);
    constexpr float kM0 = 1.0f / 21, kM1 = 1.0f / 84, kM2 = 1.0f / 252;  // of 2 z^(k+1) (1 - z)^5
    return (1 - 0.5f * f) * (1 - 0.5f * kM0) +
           roughness * (f * (1 + z * (2.0f / 3)) + (1 - f) * (kM0 + z * kM1)) +
           sqr(roughness) * f *
               (kM0 + 2 * z * kM1 + sqr(z) * kM2 + 0.5f * (1 - sqr(z)) * (kM0 - kM2));
  }
  // The same of the sheen; a fit within .01.
  static float sheen_albedo(float z) { return 0.088f * sqr(1 - z) * std::sqrt(1 - z); }
};

}  // namespace qray
