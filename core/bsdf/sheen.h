// The sheen of cloth (glTF's KHR_materials_sheen): fibres that stand up, with the distribution and
// the shadowing of Estevez and Kulla, "Production Friendly Microfacet Sheen BRDF" (2017). Their fit
// of the shadowing makes light at grazing angles; here it is divided by what is too much. The table
// of albedos is made at first use; any thread.
#pragma once

#include <array>

#include "core/math/vec.h"

namespace qray {

class Sheen {
 public:
  static const Sheen& table();

  // f of white sheen; both directions in front.
  float f(Vec3 wo, Vec3 wi, float roughness) const;
  // Share of the light from a direction of this cosine that white sheen scatters, at most 1.
  float albedo(float cosine, float roughness) const {
    return std::min(1.0f, unbounded_albedo(cosine, roughness));
  }

 private:
  static constexpr int kNodes = 33;  // at roughness and root cosine 0 ... 1
  Sheen();
  float unbounded_albedo(float cosine, float roughness) const;
  std::array<std::array<float, kNodes>, kNodes> albedos_;
};

}  // namespace qray
