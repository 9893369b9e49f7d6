// A film thinner than light is coherent, over a surface that reflects f0 head on: the colours of
// soap and of oil, after Belcour and Barla, "A Practical Extension to Microfacet Theory for the
// Modeling of Varying Iridescence" (2017), made simpler as in KHR_materials_iridescence: real
// indices, no polarisation, Schlick's Fresnel below the film. Any thread.
#pragma once

#include "core/math/vec.h"

namespace qray {

class ThinFilm {
 public:
  ThinFilm(float ior, float thickness_nm);

  // Share of the light that is reflected, by the cosine in the air. In [0, 1].
  Rgb reflectance(Rgb f0, float cosine) const;
  // The f0 of which Schlick's Fresnel reflects as much of a diffuse field of light, about.
  Rgb mean_f0(Rgb f0) const;

 private:
  float ior_, thickness_nm_;
};

}  // namespace qray
