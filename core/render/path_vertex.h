// A surface on a path, seen from where the path came: its material's BSDF, the sides on which rays
// may leave it, and what the guide was asked there. Lives within one step of a path.
#pragma once

#include <cmath>
#include <new>

#include "core/bsdf/diffuse.h"
#include "core/guide/guide.h"
#include "core/math/frame.h"
#include "core/render/caustic_map.h"
#include "core/render/material_shading.h"
#include "core/scene/surface.h"

namespace qray {

struct PathVertex {
  const SurfacePoint& surface;
  Frame frame;  // about the shading normal
  const Bsdf& bsdf;
  BsdfKind kind;
  BsdfPoint bsdf_at;  // wo is to the previous vertex
  float ray_offset;   // metres off the surface where rays may start
  const MaterialShading& material;
  const Rgb* inside;     // absorption where the path comes from, per metre; null: none
  const GuidePoint& at;  // what the guide knows there, where it is asked
  BsdfParts parts{};     // found for guides that expect, and of Lambert surfaces
  GuideMixture mixture{};
  CausticMap::Place caustics{};
  bool learns_bsdf = false;  // the guide learns here how the surface scatters (GuideNeeds::bsdf)

  GuidedSurface guided_surface() const { return {parts.base_chance, kind == BsdfKind::kMixed}; }

  // Lambert surfaces are called directly, which the compiler can inline.
  BsdfEval eval(Vec3 wi) const {
    return kind == BsdfKind::kDiffuse ? Diffuse::eval_at(bsdf_at.sp, bsdf_at.wo, wi)
                                      : bsdf.eval(bsdf_at, wi);
  }
  Rgb albedo() const {
    return kind == BsdfKind::kDiffuse ? bsdf_at.sp.reflectance : bsdf.albedo(bsdf_at);
  }
  void find_parts() {
    if (kind == BsdfKind::kDiffuse)
      parts = Diffuse::parts_at(bsdf_at.sp);
    else
      new (&parts) BsdfParts(bsdf.parts(bsdf_at));  // in place, as in PathTracer::ask_guide()
  }
  // What the density of a direction becomes with the share of those that aim at caustics.
  float with_caustics(Vec3 wi, float pdf_w) const {
    if (caustics.share == 0) return pdf_w;
    return lerp(caustics.share, pdf_w, CausticMap::pdf_w(*caustics.lobes, surface.p, wi));
  }
  // Both normals must agree on which side a direction lies, or light leaks through the surface.
  bool sides_agree(Vec3 wi, Vec3 wi_local) const { return dot(wi, surface.ng) * wi_local.z > 0; }
  Vec3 wo() const { return frame.to_world(bsdf_at.wo); }
  // Does what arrives along d go on through the surface?
  bool is_straight(Vec3 d, Vec3 wi) const { return dot(d, surface.ng) * dot(wi, surface.ng) > 0; }
  // What a ray that leaves along wi passes through: beyond a solid's boundary its inside or, coming
  // from there, the open (solids within solids are not kept apart).
  const Rgb* inside_along(Vec3 wi) const {
    if (!material.crosses(surface.ng, wo(), wi)) return inside;
    return dot(wi, surface.ng) < 0 && !material.material->absorption.is_black()
               ? &material.material->absorption
               : nullptr;
  }
  Vec3 ray_origin(Vec3 wi) const {
    return surface.p + surface.ng * std::copysign(ray_offset, dot(surface.ng, wi));
  }
};

}  // namespace qray
