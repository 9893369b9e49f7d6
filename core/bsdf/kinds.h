// The kinds behind make_bsdf(), one file each.
#pragma once

#include <memory>

#include "core/bsdf/bsdf.h"

namespace qray {

std::unique_ptr<Bsdf> make_diffuse();
std::unique_ptr<Bsdf> make_conductor(const Material& material);
std::unique_ptr<Bsdf> make_dielectric(const Material& material);
std::unique_ptr<Bsdf> make_thin_dielectric(const Material& material);
std::unique_ptr<Bsdf> make_principled(const Material& material);
std::unique_ptr<Bsdf> make_plastic(const Material& material);

// An index this near 1 is no boundary: microfacets of it would squeeze all they refract into a
// direction that floats cannot resolve.
constexpr float kLeastIndexStep = 1e-3f;

// A texture only scales the constant, so this is true or false of the whole surface.
inline bool is_smooth(const Material& material) {
  return material.roughness.value <= 0 && !material.anisotropic();
}

}  // namespace qray
