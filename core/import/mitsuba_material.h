// Mitsuba's BSDFs as materials: the same where the model is the same, else the nearest, with a
// warning. Throws ImportFailure.
#pragma once

#include "core/import/mitsuba_texture.h"

namespace qray {

class MitsubaMaterials {
 public:
  explicit MitsubaMaterials(MitsubaImport& import) : import_(import), textures_(import) {}

  struct Converted {
    Material material;
    bool vertex_colors = false;  // of the mesh multiply the reflectance
    bool inside_out = false;     // denser outside: meshes of it are turned, as the index is over 1
  };
  // Of a <bsdf>.
  Converted convert(const MitsubaNode& bsdf);
  MaterialId add(Material material);
  MitsubaTextures& textures() { return textures_; }

 private:
  Converted convert(const MitsubaNode& bsdf, bool two_sided);
  Converted convert_new(const MitsubaNode& bsdf, bool two_sided);
  Converted wrapper(const MitsubaNode& bsdf, bool two_sided);
  Material conductor(const MitsubaNode& bsdf, bool rough);
  Converted dielectric(const MitsubaNode& bsdf, bool rough);
  Material plastic(const MitsubaNode& bsdf, bool rough);
  Material principled(const MitsubaNode& bsdf);
  Rgb tinted(const MitsubaNode& bsdf, const char* name, const ColorParam& base);
  Material glossy_over_diffuse(const MitsubaNode& bsdf, bool two_sided);  // phong, ward
  Material blend(const MitsubaNode& bsdf, bool two_sided);
  Material mixture(const MitsubaNode& bsdf, bool two_sided);
  Material unknown(const MitsubaNode& bsdf);

  std::vector<const MitsubaNode*> nested(const MitsubaNode& bsdf) const;
  const MitsubaNode& only_nested(const MitsubaNode& bsdf);
  double relative_ior(const MitsubaNode& bsdf, const char* inside);
  double find_ior_of(const MitsubaNode& bsdf, std::string_view name, std::string_view fallback);
  void read_roughness(const MitsubaNode& bsdf, Material& material);

  MitsubaImport& import_;
  MitsubaTextures textures_;
  std::map<std::pair<const MitsubaNode*, bool>, Converted> known_;
  bool colored_ = false;  // a BSDF within the one that is converted asks for vertices' colours
  int depth_ = 0;
};

}  // namespace qray
