// The kinds behind make_bsdf(), one file each.
#pragma once

#include <memory>

#include "core/bsdf/bsdf.h"

namespace qray {

std::unique_ptr<Bsdf> make_diffuse();
std::unique_ptr<Bsdf> make_conductor(const Material& material);
std::unique_ptr<Bsdf> make_dielectric(const Material& material);
std::unique_ptr<Bsdf> make_plastic(const Material& material);

// A texture only scales the constant, so this is true or false of the whole surface.
inline bool is_smooth(const Material& material) { return material.roughness.value <= 0; }

}  // namespace qray
