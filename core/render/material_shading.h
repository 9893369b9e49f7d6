// What a hit needs to know of its material, side by side in memory: flags say what may be skipped,
// so that a surface pays only for what it has.
#pragma once

#include <span>

#include "core/bsdf/bsdf.h"

namespace qray {

struct MaterialShading {
  const Material* material = nullptr;
  const Bsdf* bsdf = nullptr;  // null: a blend
  ShadingPoint constant;       // the material's parameters where no texture changes them
  BsdfKind kind = BsdfKind::kDiffuse;
  bool emits = false;
  bool textured = false;      // a texture changes `constant`
  bool bends = false;         // a normal or bump map turns the shading normal
  bool masked = false;        // rays may pass; for a blend its parts counted
  bool blends = false;        // resolved to one of two others at every hit
  bool one_sided = false;     // black from behind
  bool opaque = false;        // light goes on only on the side where it comes from
  bool anisotropic = false;   // wants frames that follow the uv directions
  bool seen_whole = false;    // mirrors no eye's direction below the triangle (seen_normal)
  bool coat_bends = false;    // its coat's normal is not the shading normal
  bool bounds_solid = false;  // what passes it is inside or outside from then on
  bool pane = false;          // some light goes straight on through it (Bsdf::straight())

  // Whether the place on the surface matters.
  bool needs_uv() const {
    return textured || bends || coat_bends || masked || blends || anisotropic ||
           emission_textured();
  }
  // Whether a path from wo to wi enters or leaves a solid. ng: of the front.
  bool crosses(Vec3 ng, Vec3 wo, Vec3 wi) const {
    return bounds_solid && (dot(wi, ng) < 0) != (dot(wo, ng) < 0);
  }
  // How many times the radiance on wo's side of the boundary is there on wi's (pbrt-v4, 9.5.2).
  float eta_scale(Vec3 ng, Vec3 wo, Vec3 wi) const {
    if (!crosses(ng, wo, wi)) return 1;
    return dot(wi, ng) < 0 ? sqr(material->ior) : 1 / sqr(material->ior);
  }
  bool emission_textured() const { return emits && material->emission.texture.valid(); }
};

// `parts`: of the materials before this one, by MaterialId.
MaterialShading material_shading(const Material& material, const Bsdf* bsdf,
                                 std::span<const MaterialShading> parts);

}  // namespace qray
