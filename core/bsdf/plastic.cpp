// Plastic: a dielectric coat, smooth or of microfacets, over a Lambert base. Light passes the coat
// twice and is reflected inside any number of times (a geometric series):
//   f_base = T(wo) T(wi) rho / (n^2 (1 - rho R_in) pi),  1 - R_in = (1 - R_out) / n^2,
// T the share that the coat lets through in one direction, R_out the coat's mean albedo from
// outside, R_in from inside, n the index. This form is reciprocal, and at rho = 1 coat and base
// together have albedo 1. `nonlinear` false leaves rho out of the series (1 - R_in), as Mitsuba
// does by default: colours are then as bright as given, not more saturated.
#include "core/bsdf/coat_albedo.h"
#include "core/bsdf/fresnel.h"
#include "core/bsdf/ggx.h"
#include "core/bsdf/kinds.h"
#include "core/math/warp.h"

namespace qray {
namespace {

class PlasticBase : public Bsdf {
 public:
  explicit PlasticBase(const Material& m) : ior_(m.ior), nonlinear_(m.nonlinear) {}

 protected:
  // What the layers send back from wo's direction, in all.
  struct Layers {
    float coat_albedo;  // of a coat of specular 1
    float transmitted;  // T(wo)
    Rgb base;           // f_base * pi / (T(wo) T(wi))
    Rgb base_albedo;
    float coat_chance;  // of sampling the coat
    bool black;
  };
  Layers layers(const ShadingPoint& sp, float coat_albedo, float coat_mean) const {
    Layers l;
    l.coat_albedo = coat_albedo;
    l.transmitted = 1 - coat_albedo;
    const Rgb rho = sp.reflectance;
    const float n2 = sqr(ior_);
    l.base = nonlinear_ ? rho / (Rgb{n2} + rho * (1 - coat_mean - n2)) : rho / (1 - coat_mean);
    l.base_albedo = l.base * (l.transmitted * (1 - coat_mean));
    const float coat = luminance(sp.specular) * coat_albedo;
    const float sum = coat + luminance(l.base_albedo);
    l.black = !(sum > 0);
    l.coat_chance = l.black ? 0 : coat / sum;
    return l;
  }
  static BsdfParts parts_of(const ShadingPoint& sp, const Layers& l) {
    return {l.black ? 0 : 1 - l.coat_chance, l.base_albedo, sp.specular * l.coat_albedo};
  }
  float ior() const { return ior_; }

 private:
  float ior_;
  bool nonlinear_;
};

class SmoothPlastic final : public PlasticBase {
 public:
  explicit SmoothPlastic(const Material& m)
      : PlasticBase(m), coat_mean_(mean_fresnel_dielectric(m.ior)) {}
  BsdfKind kind() const override { return BsdfKind::kMixed; }

  BsdfEval eval(const BsdfPoint& at, Vec3 wi) const override {
    if (!(at.wo.z * wi.z > 0)) return {};
    return base(at.kept<Layers>(), std::abs(wi.z));
  }

  std::optional<BsdfSample> sample(const BsdfPoint& at, float u_lobe, Vec2 u_dir) const override {
    const Vec3 wo = at.wo;
    if (wo.z == 0) return std::nullopt;
    const Layers& l = at.kept<Layers>();
    if (l.black) return std::nullopt;
    if (u_lobe < l.coat_chance) {
      const Rgb weight = at.sp.specular * (l.coat_albedo / l.coat_chance);
      return BsdfSample{{-wo.x, -wo.y, wo.z}, weight, 0, true};
    }
    Vec3 wi = square_to_cosine_hemisphere(u_dir);
    const BsdfEval e = base(l, wi.z);
    if (!(e.pdf_w > 0)) return std::nullopt;
    wi.z = std::copysign(wi.z, wo.z);
    return BsdfSample::of(wi, e);
  }

  BsdfParts parts(const BsdfPoint& at) const override { return parts_of(at.sp, at.kept<Layers>()); }

 private:
  void prepare(BsdfPoint& at) const override {
    at.keep(layers(at.sp, coat(std::abs(at.wo.z)), coat_mean_));
  }
  float coat(float cosine) const { return fresnel_dielectric(cosine, ior()).reflectance; }
  BsdfEval base(const Layers& l, float cos_i) const {
    const float cosine = cosine_hemisphere_pdf_w(cos_i);
    const Rgb f_cos = l.base * (l.transmitted * (1 - coat(cos_i)) * cosine);
    const float pdf_w = (1 - l.coat_chance) * cosine;
    return {f_cos, pdf_w, f_cos, pdf_w};
  }

  float coat_mean_;
};

class RoughPlastic final : public PlasticBase {
 public:
  explicit RoughPlastic(const Material& m)
      : PlasticBase(m),
        coat_(m.ior, std::min(m.roughness.value, 1.0f), m.roughness.texture.valid(), m.microfacets),
        microfacets_(m.microfacets) {}
  BsdfKind kind() const override { return BsdfKind::kGlossy; }

  BsdfEval eval(const BsdfPoint& at, Vec3 wi) const override {
    if (!(at.wo.z * wi.z > 0)) return {};
    wi.z = std::abs(wi.z);
    return in_front(at, Ggx(at.sp.roughness, microfacets_), front(at.wo), wi);
  }

  std::optional<BsdfSample> sample(const BsdfPoint& at, float u_lobe, Vec2 u_dir) const override {
    if (at.wo.z == 0) return std::nullopt;
    const Layers& l = at.kept<Coated>().layers;
    if (l.black) return std::nullopt;
    const Vec3 wo = front(at.wo);
    const Ggx ggx(at.sp.roughness, microfacets_);
    Vec3 wi = u_lobe < l.coat_chance ? normalize(reflect(wo, ggx.sample(wo, u_dir)))
                                     : square_to_cosine_hemisphere(u_dir);
    if (wi.z <= 0) return std::nullopt;
    const BsdfEval e = in_front(at, ggx, wo, wi);
    if (!(e.pdf_w > 0)) return std::nullopt;
    wi.z = std::copysign(wi.z, at.wo.z);
    return BsdfSample::of(wi, e);
  }

  BsdfParts parts(const BsdfPoint& at) const override {
    return parts_of(at.sp, at.kept<Coated>().layers);
  }

 private:
  struct Coated {
    CoatAlbedo::Row row;
    Layers layers;
  };
  void prepare(BsdfPoint& at) const override {
    const CoatAlbedo::Row row = coat_.row(at.sp.roughness);
    const float coat_albedo = coat_.albedo(row, std::abs(at.wo.z));
    at.keep(Coated{row, layers(at.sp, coat_albedo, coat_.mean(row))});
  }
  static Vec3 front(Vec3 w) { return {w.x, w.y, std::abs(w.z)}; }
  // Both directions in front.
  BsdfEval in_front(const BsdfPoint& at, const Ggx& ggx, Vec3 wo, Vec3 wi) const {
    const auto& [row, l] = at.kept<Coated>();
    const Vec3 h = normalize(wo + wi);
    const float d = 0.25f * ggx.density_over_cos(h, wo);
    const float coat = 0.25f * fresnel_dielectric(dot(wo, h), ior()).reflectance *
                       ggx.d_g2_over_cos(h, wo, wi) * wi.z;
    const float cosine = cosine_hemisphere_pdf_w(wi.z);
    const float passed = l.transmitted * (1 - coat_.albedo(row, wi.z));
    const Rgb base = l.base * (passed * cosine);
    const float base_pdf_w = (1 - l.coat_chance) * cosine;
    return {at.sp.specular * coat + base, l.coat_chance * d + base_pdf_w, base, base_pdf_w};
  }

  CoatAlbedo coat_;
  Microfacets microfacets_;
};

}  // namespace

std::unique_ptr<Bsdf> make_plastic(const Material& material) {
  if (is_smooth(material)) return std::make_unique<SmoothPlastic>(material);
  return std::make_unique<RoughPlastic>(material);
}

}  // namespace qray
