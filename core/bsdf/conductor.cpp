// Metal: a mirror, or GGX microfacets that are mirrors.
#include "core/bsdf/fresnel.h"
#include "core/bsdf/ggx.h"
#include "core/bsdf/kinds.h"

namespace qray {
namespace {

class ConductorBase : public Bsdf {
 public:
  explicit ConductorBase(const Material& m) : eta_(m.eta), k_(m.k) {}

  BsdfParts parts(const BsdfPoint& at) const override {
    return {0, {}, fresnel(at.sp, std::abs(at.wo.z))};
  }

 protected:
  Rgb fresnel(const ShadingPoint& sp, float cos_i) const {
    return sp.specular * Rgb{fresnel_conductor(cos_i, eta_.r, k_.r),
                             fresnel_conductor(cos_i, eta_.g, k_.g),
                             fresnel_conductor(cos_i, eta_.b, k_.b)};
  }

 private:
  Rgb eta_, k_;
};

class SmoothConductor final : public ConductorBase {
 public:
  using ConductorBase::ConductorBase;
  BsdfKind kind() const override { return BsdfKind::kDelta; }
  BsdfEval eval(const BsdfPoint&, Vec3) const override { return {}; }
  std::optional<BsdfSample> sample(const BsdfPoint& at, float, Vec2) const override {
    const Vec3 wo = at.wo;
    if (wo.z == 0) return std::nullopt;
    return BsdfSample{{-wo.x, -wo.y, wo.z}, fresnel(at.sp, std::abs(wo.z)), 0, true};
  }
};

class RoughConductor final : public ConductorBase {
 public:
  explicit RoughConductor(const Material& m) : ConductorBase(m), microfacets_(m.microfacets) {}
  BsdfKind kind() const override { return BsdfKind::kGlossy; }

  BsdfEval eval(const BsdfPoint& at, Vec3 wi) const override {
    Vec3 wo = at.wo;
    if (!(wo.z * wi.z > 0)) return {};
    to_front(wo, wi);
    const Vec3 h = normalize(wo + wi);
    const Ggx ggx(at.sp.roughness, microfacets_, at.sp.anisotropy);
    const float f_cos = 0.25f * ggx.d_g2_over_cos(h, wo, wi) * wi.z;
    return {fresnel(at.sp, dot(wo, h)) * f_cos, 0.25f * ggx.density_over_cos(h, wo)};
  }

  std::optional<BsdfSample> sample(const BsdfPoint& at, float, Vec2 u_dir) const override {
    Vec3 wo = at.wo;
    if (wo.z == 0) return std::nullopt;
    const float side = std::copysign(1.0f, wo.z);
    wo.z = std::abs(wo.z);
    const Ggx ggx(at.sp.roughness, microfacets_, at.sp.anisotropy);
    const Vec3 h = ggx.sample(wo, u_dir);
    Vec3 wi = normalize(reflect(wo, h));
    if (wi.z <= 0) return std::nullopt;
    const Rgb weight = fresnel(at.sp, dot(wo, h)) * ggx.weight(h, wo, wi);
    const float pdf_w = 0.25f * ggx.density_over_cos(h, wo);
    wi.z *= side;
    return BsdfSample{wi, weight, pdf_w, false};
  }

 private:
  static void to_front(Vec3& wo, Vec3& wi) {
    wo.z = std::abs(wo.z);
    wi.z = std::abs(wi.z);
  }

  Microfacets microfacets_;
};

}  // namespace

std::unique_ptr<Bsdf> make_conductor(const Material& material) {
  if (is_smooth(material)) return std::make_unique<SmoothConductor>(material);
  return std::make_unique<RoughConductor>(material);
}

}  // namespace qray
