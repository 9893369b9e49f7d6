// Glass: a boundary that reflects and refracts, smooth or of GGX microfacets (Walter et al. 2007).
// Radiance that crosses the boundary is scaled by the square of the relative index
// (pbrt-v4, 9.5.2), so eval() is not reciprocal there.
#include "core/bsdf/fresnel.h"
#include "core/bsdf/ggx.h"
#include "core/bsdf/kinds.h"

namespace qray {
namespace {

// An index this near 1 is no boundary: microfacets of it would squeeze all they refract into a
// direction that floats cannot resolve.
constexpr float kLeastIndexStep = 1e-3f;

class DielectricBase : public Bsdf {
 public:
  explicit DielectricBase(const Material& m) : ior_(m.ior), specular_(m.specular.value) {}
  Rgb albedo(const ShadingPoint&, Vec3) const override { return specular_; }

 protected:
  // The index beyond the surface, seen from wo, over that before it.
  float eta(Vec3 wo) const { return wo.z > 0 ? ior_ : 1 / ior_; }
  Rgb specular() const { return specular_; }

 private:
  float ior_;
  Rgb specular_;
};

class SmoothDielectric final : public DielectricBase {
 public:
  using DielectricBase::DielectricBase;
  BsdfKind kind() const override { return BsdfKind::kDelta; }
  BsdfEval eval(const ShadingPoint&, Vec3, Vec3) const override { return {}; }

  // The lobe's chance is its share, so both cancel.
  std::optional<BsdfSample> sample(const ShadingPoint&, Vec3 wo, float u_lobe,
                                   Vec2) const override {
    if (wo.z == 0) return std::nullopt;
    const float eta = this->eta(wo);
    const DielectricFresnel f = fresnel_dielectric(std::abs(wo.z), eta);
    if (u_lobe < f.reflectance) return BsdfSample{{-wo.x, -wo.y, wo.z}, specular(), 0, true};
    if (f.cos_t == 0) return std::nullopt;
    const Vec3 wi{-wo.x / eta, -wo.y / eta, -std::copysign(f.cos_t, wo.z)};
    return BsdfSample{normalize(wi), specular() / sqr(eta), 0, true};
  }
};

class RoughDielectric final : public DielectricBase {
 public:
  using DielectricBase::DielectricBase;
  BsdfKind kind() const override { return BsdfKind::kGlossy; }

  BsdfEval eval(const ShadingPoint& sp, Vec3 wo, Vec3 wi) const override {
    if (wo.z == 0 || wi.z == 0) return {};
    const float eta = this->eta(wo);
    to_front(wo, wi);
    const Ggx ggx(sp.roughness);
    if (wi.z > 0) {
      const Vec3 h = normalize(wo + wi);
      const float f = fresnel_dielectric(dot(wo, h), eta).reflectance;
      return reflected(ggx, wo, wi, h, f);
    }
    // Generalised half vector, Walter et al. eq. 16, on wo's side.
    Vec3 h = wo + wi * eta;
    const float size = length(h);
    if (size == 0) return {};
    h = h / std::copysign(size, h.z);
    if (dot(wo, h) <= 0 || dot(wi, h) >= 0) return {};
    const float f = fresnel_dielectric(dot(wo, h), eta).reflectance;
    return refracted(ggx, wo, wi, h, 1 - f, eta);
  }

  std::optional<BsdfSample> sample(const ShadingPoint& sp, Vec3 wo, float u_lobe,
                                   Vec2 u_dir) const override {
    if (wo.z == 0) return std::nullopt;
    const float eta = this->eta(wo);
    const float side = std::copysign(1.0f, wo.z);
    wo.z = std::abs(wo.z);
    const Ggx ggx(sp.roughness);
    const Vec3 h = ggx.sample_visible(wo, u_dir);
    const float cos_o = dot(wo, h);
    if (cos_o <= 0) return std::nullopt;
    const DielectricFresnel f = fresnel_dielectric(cos_o, eta);

    BsdfSample s;
    if (u_lobe < f.reflectance) {
      s.wi = normalize(reflect(wo, h));
      if (s.wi.z <= 0) return std::nullopt;
      s.pdf_w = reflected(ggx, wo, s.wi, h, f.reflectance).pdf_w;
      s.weight = specular() * ggx.g2_over_g1(wo, s.wi);
    } else {
      s.wi = normalize(h * (cos_o / eta - f.cos_t) - wo / eta);
      if (s.wi.z >= 0 || f.cos_t == 0) return std::nullopt;
      s.pdf_w = refracted(ggx, wo, s.wi, h, 1 - f.reflectance, eta).pdf_w;
      s.weight = specular() * (ggx.g2_over_g1(wo, s.wi) / sqr(eta));
    }
    s.wi.z *= side;
    return s;
  }

 private:
  static void to_front(Vec3& wo, Vec3& wi) {
    wi.z *= std::copysign(1.0f, wo.z);
    wo.z = std::abs(wo.z);
  }
  BsdfEval reflected(const Ggx& ggx, Vec3 wo, Vec3 wi, Vec3 h, float share) const {
    const float d = 0.25f * share * ggx.d(h);
    return {specular() * (d * ggx.g2_over_cos(wo, wi) * wi.z), d * ggx.g1_over_cos(wo)};
  }
  // Walter et al. eq. 17 and 21, over eta^2 for radiance.
  BsdfEval refracted(const Ggx& ggx, Vec3 wo, Vec3 wi, Vec3 h, float share, float eta) const {
    const float cos_o = dot(wo, h), cos_i = -dot(wi, h);
    const float jacobian = sqr(eta) * cos_i / sqr(eta * cos_i - cos_o);
    const float d = share * ggx.d(h) * cos_o * jacobian;
    if (!std::isfinite(d)) return {};
    return {specular() * (d * ggx.g2_over_cos(wo, wi) * -wi.z / sqr(eta)), d * ggx.g1_over_cos(wo)};
  }
};

}  // namespace

std::unique_ptr<Bsdf> make_dielectric(const Material& material) {
  if (is_smooth(material) || std::abs(material.ior - 1) < kLeastIndexStep)
    return std::make_unique<SmoothDielectric>(material);
  return std::make_unique<RoughDielectric>(material);
}

}  // namespace qray
