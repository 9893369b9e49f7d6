// Glass: a boundary that reflects and refracts, smooth or of GGX microfacets (Walter et al. 2007).
// Radiance that crosses the boundary is scaled by the square of the relative index
// (pbrt-v4, 9.5.2), so eval() is not reciprocal there. And a pane of glass: both its faces as one
// surface, between which light is reflected any number of times (Stokes 1862).
#include "core/bsdf/fresnel.h"
#include "core/bsdf/ggx.h"
#include "core/bsdf/kinds.h"

namespace qray {
namespace {

class DielectricBase : public Bsdf {
 public:
  explicit DielectricBase(const Material& m) : ior_(m.ior) {}
  BsdfParts parts(const BsdfPoint& at) const override {
    return {0, {}, lerp(reflectance(at.wo), at.sp.transmittance, at.sp.specular)};
  }

 protected:
  // The index beyond the surface, seen from wo, over that before it.
  float eta(Vec3 wo) const { return wo.z > 0 ? ior_ : 1 / ior_; }
  float ior() const { return ior_; }
  // Of the flat surface, before colours.
  virtual float reflectance(Vec3 wo) const {
    return fresnel_dielectric(std::abs(wo.z), eta(wo)).reflectance;
  }

  // Shares of the light, and the chance to sample the reflected: in proportion to the shares after
  // their colours, so that black glass wastes no sample on what does not pass.
  struct Split {
    float reflected, passed, reflect_chance;
  };
  static Split split(const ShadingPoint& sp, float reflectance) {
    const float passed = 1 - reflectance;
    const float r = reflectance * max_component(sp.specular),
                t = passed * max_component(sp.transmittance);
    return {reflectance, passed, t > 0 ? r / (r + t) : 1};
  }

 private:
  float ior_;
};

class SmoothDielectric final : public DielectricBase {
 public:
  using DielectricBase::DielectricBase;
  BsdfKind kind() const override { return BsdfKind::kDelta; }
  BsdfEval eval(const BsdfPoint&, Vec3) const override { return {}; }

  std::optional<BsdfSample> sample(const BsdfPoint& at, float u_lobe, Vec2) const override {
    const Vec3 wo = at.wo;
    if (wo.z == 0) return std::nullopt;
    const float eta = this->eta(wo);
    const DielectricFresnel f = fresnel_dielectric(std::abs(wo.z), eta);
    const Split s = split(at.sp, f.reflectance);
    if (u_lobe < s.reflect_chance) {
      const Rgb weight = at.sp.specular * (s.reflected / s.reflect_chance);
      return BsdfSample{{-wo.x, -wo.y, wo.z}, weight, 0, true};
    }
    if (f.cos_t == 0) return std::nullopt;
    const Vec3 wi{-wo.x / eta, -wo.y / eta, -std::copysign(f.cos_t, wo.z)};
    const Rgb weight = at.sp.transmittance * (s.passed / ((1 - s.reflect_chance) * sqr(eta)));
    return BsdfSample{normalize(wi), weight, 0, true};
  }
};

class RoughDielectric final : public DielectricBase {
 public:
  explicit RoughDielectric(const Material& m) : DielectricBase(m), microfacets_(m.microfacets) {}
  BsdfKind kind() const override { return BsdfKind::kGlossy; }

  BsdfEval eval(const BsdfPoint& at, Vec3 wi) const override {
    const ShadingPoint& sp = at.sp;
    Vec3 wo = at.wo;
    if (wo.z == 0 || wi.z == 0) return {};
    const float eta = this->eta(wo);
    to_front(wo, wi);
    const Ggx ggx(sp.roughness, microfacets_, sp.anisotropy);
    if (wi.z > 0) {
      const Vec3 h = normalize(wo + wi);
      return reflected(sp, ggx, wo, wi, h,
                       split(sp, fresnel_dielectric(dot(wo, h), eta).reflectance));
    }
    // Generalised half vector, Walter et al. eq. 16, on wo's side.
    Vec3 h = wo + wi * eta;
    const float size = length(h);
    if (size == 0) return {};
    h = h / std::copysign(size, h.z);
    if (dot(wo, h) <= 0 || dot(wi, h) >= 0) return {};
    return refracted(sp, ggx, wo, wi, h, split(sp, fresnel_dielectric(dot(wo, h), eta).reflectance),
                     eta);
  }

  std::optional<BsdfSample> sample(const BsdfPoint& at, float u_lobe, Vec2 u_dir) const override {
    const ShadingPoint& sp = at.sp;
    Vec3 wo = at.wo;
    if (wo.z == 0) return std::nullopt;
    const float eta = this->eta(wo);
    const float side = std::copysign(1.0f, wo.z);
    wo.z = std::abs(wo.z);
    const Ggx ggx(sp.roughness, microfacets_, sp.anisotropy);
    const Vec3 h = ggx.sample(wo, u_dir);
    const float cos_o = dot(wo, h);
    if (cos_o <= 0) return std::nullopt;
    const DielectricFresnel f = fresnel_dielectric(cos_o, eta);

    const Split share = split(sp, f.reflectance);

    BsdfSample s;
    if (u_lobe < share.reflect_chance) {
      s.wi = normalize(reflect(wo, h));
      if (s.wi.z <= 0) return std::nullopt;
      s.pdf_w = reflected(sp, ggx, wo, s.wi, h, share).pdf_w;
      s.weight = sp.specular * (ggx.weight(h, wo, s.wi) * share.reflected / share.reflect_chance);
    } else {
      s.wi = normalize(h * (cos_o / eta - f.cos_t) - wo / eta);
      if (s.wi.z >= 0 || f.cos_t == 0) return std::nullopt;
      s.pdf_w = refracted(sp, ggx, wo, s.wi, h, share, eta).pdf_w;
      s.weight = sp.transmittance *
                 (ggx.weight(h, wo, s.wi) * share.passed / ((1 - share.reflect_chance) * sqr(eta)));
    }
    s.wi.z *= side;
    return s;
  }

 private:
  static void to_front(Vec3& wo, Vec3& wi) {
    wi.z *= std::copysign(1.0f, wo.z);
    wo.z = std::abs(wo.z);
  }
  BsdfEval reflected(const ShadingPoint& sp, const Ggx& ggx, Vec3 wo, Vec3 wi, Vec3 h,
                     const Split& share) const {
    return {sp.specular * (0.25f * share.reflected * ggx.d_g2_over_cos(h, wo, wi) * wi.z),
            0.25f * share.reflect_chance * ggx.density_over_cos(h, wo)};
  }
  // Walter et al. eq. 17 and 21, over eta^2 for radiance.
  BsdfEval refracted(const ShadingPoint& sp, const Ggx& ggx, Vec3 wo, Vec3 wi, Vec3 h,
                     const Split& share, float eta) const {
    const float cos_o = dot(wo, h), cos_i = -dot(wi, h);
    const float jacobian = sqr(eta) * cos_i / sqr(eta * cos_i - cos_o);
    const float facets = cos_o * jacobian, d = facets * ggx.density_over_cos(h, wo);
    if (!std::isfinite(d)) return {};
    const float passed = share.passed * facets * ggx.d_g2_over_cos(h, wo, wi) * -wi.z / sqr(eta);
    return {sp.transmittance * passed, (1 - share.reflect_chance) * d};
  }

  Microfacets microfacets_;
};

// Light goes straight on, displaced by less than is modelled.
class ThinDielectric final : public DielectricBase {
 public:
  using DielectricBase::DielectricBase;
  BsdfKind kind() const override { return BsdfKind::kDelta; }
  BsdfEval eval(const BsdfPoint&, Vec3) const override { return {}; }

  std::optional<BsdfSample> sample(const BsdfPoint& at, float u_lobe, Vec2) const override {
    const Vec3 wo = at.wo;
    if (wo.z == 0) return std::nullopt;
    const Split s = split(at.sp, reflectance(wo));
    if (u_lobe < s.reflect_chance) {
      const Rgb weight = at.sp.specular * (s.reflected / s.reflect_chance);
      return BsdfSample{{-wo.x, -wo.y, wo.z}, weight, 0, true};
    }
    return BsdfSample{-wo, at.sp.transmittance * (s.passed / (1 - s.reflect_chance)), 0, true};
  }
  Rgb straight(const BsdfPoint& at) const override {
    return at.wo.z == 0 ? Rgb{} : at.sp.transmittance * (1 - reflectance(at.wo));
  }

 private:
  float reflectance(Vec3 wo) const override {
    // R + T^2 R + T^2 R^3 + ... with T = 1 - R.
    const float one_face = fresnel_dielectric(std::abs(wo.z), ior()).reflectance;
    return 2 * one_face / (1 + one_face);
  }
};

}  // namespace

std::unique_ptr<Bsdf> make_thin_dielectric(const Material& material) {
  return std::make_unique<ThinDielectric>(material);
}

std::unique_ptr<Bsdf> make_dielectric(const Material& material) {
  if (is_smooth(material) || std::abs(material.ior - 1) < kLeastIndexStep)
    return std::make_unique<SmoothDielectric>(material);
  return std::make_unique<RoughDielectric>(material);
}

}  // namespace qray
