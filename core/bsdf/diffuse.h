// Lambert: f = reflectance / pi. In a header so that the path tracer can inline the commonest
// surface; everybody else goes through Bsdf.
#pragma once

#include "core/bsdf/bsdf.h"
#include "core/math/warp.h"

namespace qray {

class Diffuse final : public Bsdf {
 public:
  static BsdfEval eval_at(const ShadingPoint& sp, Vec3 wo, Vec3 wi) {
    if (!(wo.z * wi.z > 0)) return {};
    const float pdf_w = cosine_hemisphere_pdf_w(std::abs(wi.z));
    const Rgb f_cos = sp.reflectance * pdf_w;
    return {f_cos, pdf_w, f_cos, pdf_w};
  }
  static std::optional<BsdfSample> sample_at(const ShadingPoint& sp, Vec3 wo, Vec2 u_dir) {
    Vec3 wi = square_to_cosine_hemisphere(u_dir);
    const float pdf_w = cosine_hemisphere_pdf_w(wi.z);
    if (wo.z == 0 || pdf_w == 0) return std::nullopt;
    wi.z = std::copysign(wi.z, wo.z);
    return BsdfSample{wi, sp.reflectance, pdf_w, false, sp.reflectance, pdf_w};
  }

  static BsdfParts parts_at(const ShadingPoint& sp) { return {1, sp.reflectance, {}}; }

  BsdfKind kind() const override { return BsdfKind::kDiffuse; }
  BsdfEval eval(const BsdfPoint& at, Vec3 wi) const override { return eval_at(at.sp, at.wo, wi); }
  std::optional<BsdfSample> sample(const BsdfPoint& at, float, Vec2 u_dir) const override {
    return sample_at(at.sp, at.wo, u_dir);
  }
  BsdfParts parts(const BsdfPoint& at) const override { return parts_at(at.sp); }
};

}  // namespace qray
