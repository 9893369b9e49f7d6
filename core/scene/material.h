// What a surface is made of, as read from a scene file. Plain data; bsdf/ turns it into a Bsdf.
// Ranges are checked by validate.cpp.
#pragma once

#include <string>

#include "core/base/ids.h"
#include "core/math/vec.h"

namespace qray {

enum class MaterialKind : uint8_t { kDiffuse, kConductor, kDielectric, kPlastic };

// A colour or number, times an image where `texture` is valid.
struct ColorParam {
  Rgb value;
  TextureId texture;
  bool operator==(const ColorParam&) const = default;
};
struct FloatParam {
  float value = 0;
  TextureId texture;  // its first channel
  bool operator==(const FloatParam&) const = default;
};

struct Material {
  std::string name;
  MaterialKind kind = MaterialKind::kDiffuse;
  ColorParam reflectance{Rgb{0.5f}, {}};  // diffuse: albedo; plastic: albedo of the base
  FloatParam roughness{};                 // 0 = smooth, 1 = roughest; GGX alpha = roughness^2
  Rgb eta{0.2f, 0.92f, 1.1f};             // conductor: complex index of refraction eta + i k
  Rgb k{3.9f, 2.45f, 2.14f};
  float ior = 1.5f;    // dielectric, plastic: inside over outside
  Rgb specular{1.0f};  // conductor, dielectric, plastic: scales the coat
  // Radiance leaving the front (W sr^-1 m^-2 per channel), the side the geometric normal points to.
  Rgb emission{};
  bool emission_two_sided = false;

  bool emits() const { return max_component(emission) > 0; }
};

}  // namespace qray
