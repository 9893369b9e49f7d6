// What a surface is made of, as read from a scene file. Plain data; bsdf/ turns it into a Bsdf.
// Ranges are checked by validate.cpp, docs/scene_format.md says what each field does.
#pragma once

#include <string>

#include "core/base/ids.h"
#include "core/math/vec.h"

namespace qray {

enum class MaterialKind : uint8_t {
  kDiffuse,
  kConductor,
  kDielectric,  // a closed solid
  kPlastic,
  kThinDielectric,  // a pane: both its faces in one surface
  kPrincipled,      // glTF 2.0, appendix B, with its KHR_materials extensions
  kBlend,           // of two other materials
};

// Of rough kinds but the principled one.
enum class Microfacets : uint8_t { kGgx, kBeckmann };

// A colour or number, times an image where `texture` is valid.
struct ColorParam {
  Rgb value{};
  TextureId texture{};
  bool operator==(const ColorParam&) const = default;
};
constexpr int kLuminance = 4;  // a channel made of red, green and blue
struct FloatParam {
  float value = 0;
  TextureId texture{};
  int channel = 0;  // of the image: red, green, blue, alpha (1 where it has none), kLuminance
  bool operator==(const FloatParam&) const = default;
};

struct Material {
  std::string name;
  MaterialKind kind = MaterialKind::kDiffuse;
  // Diffuse: albedo; plastic: albedo of the base; principled: base colour.
  ColorParam reflectance{Rgb{0.5f}};
  FloatParam roughness{};  // 0 = smooth, 1 = roughest; alpha = roughness^2
  // Conductor, dielectric, principled: along one direction alpha is raised by this share squared of
  // what it lacks to 1 (KHR_materials_anisotropy). That direction: radians from the one in which u
  // grows, toward the one in which v does.
  FloatParam anisotropy{};
  float anisotropy_rad = 0;
  bool anisotropy_directions = false;  // turned by red and green of its texture, 2 rg - 1
  Microfacets microfacets = Microfacets::kGgx;
  Rgb eta{0.2f, 0.92f, 1.1f};  // conductor: complex index of refraction eta + i k
  Rgb k{3.9f, 2.45f, 2.14f};
  float ior = 1.5f;  // dielectrics, plastic, principled: inside over outside
  // Conductor, dielectrics, plastic: scales what is reflected as in a mirror. Principled: colour of
  // what a dielectric reflects at normal incidence, over 1 too (KHR_materials_specular's colour).
  ColorParam specular{Rgb{1.0f}};
  ColorParam transmittance{Rgb{1.0f}};  // dielectrics: scales what passes the surface

  // Dielectric, principled: 1/m, of light inside; the surface must be closed.
  Rgb absorption{};
  bool nonlinear = true;  // plastic: light reflected inside is coloured at every return

  // Principled alone. The shares of metal, of what passes where the rest would scatter diffusely,
  // of the coat above all; `specular_weight` scales what the dielectric reflects at all angles.
  FloatParam metallic{}, transmission{}, clearcoat{}, clearcoat_roughness{}, specular_weight{1.0f};
  // Principled: of cloth, on all but the coat.
  ColorParam sheen{};
  FloatParam sheen_roughness{0.5f};
  // Principled: Disney's model of 2012 and 2015 instead of glTF's. What is diffuse is Burley's and
  // keeps all that the facets would leave, the sheen is Disney's, what passes is coloured by the
  // root of the base colour, and a solid that light passes is diffuse from outside alone.
  bool disney = false;
  bool thin = false;  // principled: what passes is not bent, the surface is a sheet
  // Principled: the share of the diffuse part that leaves on the other side, in a colour of its
  // own.
  FloatParam diffuse_transmission{};
  ColorParam diffuse_transmission_color{Rgb{1.0f}};
  // Principled: a film on what is below coat and sheen, by its share; its index, and its thickness
  // in nanometres. A texture's 0 is the least thickness, its 1 the value.
  FloatParam iridescence{};
  float film_ior = 1.3f;
  FloatParam film_nm{400.0f};
  float film_least_nm = 100;
  // Principled: whether the coat has normals of its own: coat_normal_map's, or else the mesh's.
  bool own_coat_normal = false;
  TextureId coat_normal_map;
  float coat_normal_scale = 1;

  // Blend: `second` by this share, `first` by the rest; both before it in Scene::materials. What
  // they emit does not count.
  MaterialId first, second;
  FloatParam blend_weight{0.5f};

  // Any kind. Light that meets what is not opaque goes straight on. With a cutoff over 0, opacity
  // is 1 where it reaches that and 0 elsewhere.
  FloatParam opacity{1.0f};
  float alpha_cutoff = 0;
  TextureId normal_map;  // tangent space, (rgb * 2 - 1) with x and y times its scale
  float normal_scale = 1;
  FloatParam bump_map{1.0f};  // height, metres; counts where it has a texture
  bool two_sided = true;      // opaque kinds: false is black from behind

  // Radiance leaving the front (W sr^-1 m^-2 per channel), the side the geometric normal points to.
  ColorParam emission{};
  bool emission_two_sided = false;
  std::string light_group;  // of what it emits; empty: none

  bool anisotropic() const { return anisotropy.value > 0; }
  bool emits() const { return max_component(emission.value) > 0; }
};

}  // namespace qray
