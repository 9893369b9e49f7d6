// glTF 2.0's material (specification, appendix B.3) with KHR_materials_ior, specular, transmission,
// volume (`thin` false), diffuse_transmission, clearcoat, sheen and iridescence. From the top:
//   a clear coat of index 1.5, GGX, by its share c;
//   the sheen of cloth, by its colour s;
//   GGX microfacets of Schlick's Fresnel, metal by its share m and dielectric by the rest;
//   under the dielectric what passes them, by its share t, and Lambert by the rest, of which a
//   share leaves on the other side.
// The specification mixes layers by the Fresnel term at the half vector, which makes light at
// grazing angles (up to 1.8 times what arrives). Here the layers below get what the directional
// albedos leave: Lambert as in plastic.cpp, (1 - E(wo)) (1 - E(wi)) / (1 - mean E), with E the
// greatest channel's; all below the coat 1 - c max(E(wo), E(wi)) (Dassault Systemes Enterprise
// PBR), and all below the sheen alike, with s's greatest channel. All are reciprocal, and no light
// is made.
//
// With `disney` it is the model of Burley 2012 and 2015 as other renderers have it: diffuse part
// and sheen are burley.h's, neither is weighed by what the facets leave, and they make light at
// grazing angles; what passes is coloured by the root of the base colour.
#include "core/bsdf/burley.h"
#include "core/bsdf/fresnel.h"
#include "core/bsdf/ggx_albedo.h"
#include "core/bsdf/kinds.h"
#include "core/bsdf/sheen.h"
#include "core/bsdf/thin_film.h"
#include "core/math/frame.h"
#include "core/math/warp.h"

namespace qray {
namespace {

constexpr Rgb kCoatF0{0.04f}, kCoatF90{1.0f};

// Where no texture brings it above 0.
bool absent(const FloatParam& p) { return p.value <= 0; }
bool absent(const ColorParam& p) { return max_component(p.value) <= 0; }

class Principled final : public Bsdf {
 public:
  explicit Principled(const Material& m)
      : table_(GgxAlbedo::table()),
        sheen_(absent(m.sheen) || m.disney ? nullptr : &Sheen::table()),
        ior_(m.ior),
        film_ior_(m.film_ior),
        film_(!absent(m.iridescence)),
        disney_(m.disney),
        thin_(m.thin || m.ior - 1 < kLeastIndexStep),
        smooth_(is_smooth(m)),
        smooth_coat_(absent(m.clearcoat_roughness)),
        kind_(kind_of(m)) {}

  BsdfKind kind() const override { return kind_; }

  BsdfEval eval(const BsdfPoint& at, Vec3 wi) const override {
    if (at.wo.z == 0 || wi.z == 0) return {};
    return eval(at.sp, at.kept<Layers>(), at.wo, wi);
  }

  std::optional<BsdfSample> sample(const BsdfPoint& at, float u_lobe, Vec2 u_dir) const override {
    const ShadingPoint& sp = at.sp;
    const Layers& l = at.kept<Layers>();
    const Vec3 wo = at.wo;
    if (wo.z == 0) return std::nullopt;
    Vec3 wi;
    if (u_lobe < l.coat_chance) {
      const Frame coat(coat_normal(sp, wo));
      const Vec3 o = coat.to_local(front(wo));
      const Vec3 h =
          smooth_coat_ ? Vec3{0, 0, 1} : Ggx(sp.clearcoat_roughness).sample_visible(o, u_dir);
      const Vec3 i = reflect(o, h);
      wi = coat.to_world(i);
      if (!(i.z > 0 && wi.z > 0)) return std::nullopt;
      wi.z = std::copysign(wi.z, wo.z);
      if (smooth_coat_) {
        const Rgb f = schlick(kCoatF0, kCoatF90, o.z);
        return BsdfSample{normalize(wi), f * (sp.clearcoat / l.coat_chance), 0, true};
      }
    } else if (u_lobe < l.coat_chance + l.sheen_chance) {
      wi = square_to_uniform_hemisphere(u_dir);
      wi.z = std::copysign(wi.z, wo.z);
    } else if (u_lobe < l.coat_chance + l.sheen_chance + l.facet_chance) {
      const float u_facet =
          std::min((u_lobe - l.coat_chance - l.sheen_chance) / l.facet_chance, kOneMinusEpsilon);
      const Vec3 h = smooth_ ? Vec3{0, 0, 1} : microfacets(sp).sample_visible(front(wo), u_dir);
      const Facet f = facet(sp, l, wo, h);
      const bool reflects = u_facet < f.reflect_chance;
      if (!reflects && f.passed.is_black()) return std::nullopt;
      wi = reflects ? reflected(wo, h) : passed(wo, h, f);
      if (smooth_) {
        const float chance = l.facet_chance * (reflects ? f.reflect_chance : 1 - f.reflect_chance);
        const float radiance = reflects || thin_ ? 1.0f : 1 / sqr(eta(wo));
        const Rgb share = (reflects ? f.reflected : f.passed) * (under(sp, l, wi) * radiance);
        return BsdfSample{normalize(wi), share / chance, 0, true};
      }
      if (reflects != (wi.z * wo.z > 0)) return std::nullopt;
    } else if (u_lobe < 1 - l.diffuse_chance && l.through_chance > 0) {
      wi = square_to_cosine_hemisphere(u_dir);
      wi.z = std::copysign(wi.z, -wo.z);
    } else {
      if (l.diffuse_chance == 0) return std::nullopt;
      wi = square_to_cosine_hemisphere(u_dir);
      wi.z = std::copysign(wi.z, wo.z);
    }
    if (wi.z == 0) return std::nullopt;
    wi = normalize(wi);
    const BsdfEval e = eval(sp, l, wo, wi);
    if (!(e.pdf_w > 0)) return std::nullopt;
    return BsdfSample::of(wi, e);
  }

  BsdfParts parts(const BsdfPoint& at) const override {
    const Layers& l = at.kept<Layers>();
    const float below = (1 - l.coat) * (1 - l.sheen);
    return {l.diffuse_chance, l.diffuse_albedo * below,
            Rgb{l.coat} + sheen_albedo(at.sp, at.wo.z) * (1 - l.coat) +
                (l.facets + l.through_albedo) * below};
  }

  Rgb straight(const BsdfPoint& at) const override {
    if (!thin_ || !smooth_ || at.wo.z == 0) return {};
    const Layers& l = at.kept<Layers>();
    return facet(at.sp, l, at.wo, {0, 0, 1}).passed * under(at.sp, l, -at.wo);
  }

 private:
  // What a shading point makes of the layers, seen from wo.
  struct Layers {
    // Of metal and dielectric together, and of the dielectric; with a film about.
    Rgb f0, f90, dielectric_f0, dielectric_f90;
    float coat;   // its albedo times its share
    float sheen;  // its albedo's greatest channel
    Rgb passes;   // share of what enters the dielectric that passes it
    Rgb facets;   // albedo of the microfacets, reflected and passed
    Rgb diffuse;  // f * pi / ((1 - E(wo)) (1 - E(wi))); of Disney's, over Burley's terms
    Rgb diffuse_albedo;
    Rgb through;  // as `diffuse`, of what leaves on the other side
    Rgb through_albedo;
    float open;  // 1 - E(wo)
    float coat_chance, sheen_chance, facet_chance, through_chance, diffuse_chance;
  };
  void prepare(BsdfPoint& at) const override { at.keep(layers(at.sp, at.wo)); }
  Layers layers(const ShadingPoint& sp, Vec3 wo) const {
    Layers l;
    l.dielectric_f0 = dielectric_f0(sp) * sp.specular_weight;
    l.dielectric_f90 = Rgb{sp.specular_weight};
    Rgb metal_f0 = sp.reflectance;
    if (film_ && sp.iridescence > 0) {
      const ThinFilm film(film_ior_, sp.film_nm);
      l.dielectric_f0 = lerp(sp.iridescence, l.dielectric_f0,
                             film.mean_f0(dielectric_f0(sp)) * sp.specular_weight);
      if (sp.metallic > 0) metal_f0 = lerp(sp.iridescence, metal_f0, film.mean_f0(metal_f0));
    }
    l.f0 = lerp(sp.metallic, l.dielectric_f0, metal_f0);
    l.f90 = lerp(sp.metallic, l.dielectric_f90, Rgb{1.0f});
    l.coat = coat_albedo(sp, dot(front(wo), coat_normal(sp, wo)));
    const Rgb sheen_color = sheen_albedo(sp, wo.z);
    l.sheen = max_component(sheen_color);

    const float below = 1 - sp.metallic;
    l.passes = (disney_ ? root(sp.reflectance) : sp.reflectance) * (below * sp.transmission);
    const GgxAlbedo::Value at = table_.at(roughness_along(sp, wo), std::abs(wo.z));
    l.open = 1 - max_component(at.of(l.dielectric_f0, l.dielectric_f90));
    l.facets = at.of(l.f0, l.f90) + l.passes * l.open;
    const float mean_open =
        1 - max_component(table_.mean(mean_roughness(sp)).of(l.dielectric_f0, l.dielectric_f90));
    const float lambert = mean_open > 1e-4f ? below * (1 - sp.transmission) / mean_open : 0;
    l.diffuse = sp.reflectance * (lambert * (1 - sp.diffuse_transmission));
    l.diffuse_albedo = l.diffuse * (l.open * mean_open);
    if (disney_) {
      const float z = std::abs(wo.z);
      l.diffuse = burley(sp, wo, sp.reflectance * (1 - sp.transmission));
      l.diffuse_albedo = l.diffuse * Burley::albedo(z, sp.roughness) +
                         burley(sp, wo, sp.sheen) * Burley::sheen_albedo(z);
    }
    l.through = sp.diffuse_transmission_color * (lambert * sp.diffuse_transmission);
    l.through_albedo = l.through * (l.open * mean_open);

    const float coat = l.coat, sheen = (1 - coat) * luminance(sheen_color),
                left = (1 - coat) * (1 - l.sheen), facets = left * luminance(l.facets),
                through = left * luminance(l.through_albedo),
                diffuse = left * luminance(l.diffuse_albedo);
    const float sum = coat + sheen + facets + through + diffuse;
    const float inverse = sum > 0 ? 1 / sum : 0;
    l.coat_chance = coat * inverse;
    l.sheen_chance = sheen * inverse;
    l.facet_chance = facets * inverse;
    l.through_chance = through * inverse;
    l.diffuse_chance = diffuse * inverse;
    return l;
  }
  // A colour of the Disney model's diffuse part: metal has none, nor has a solid from inside.
  Rgb burley(const ShadingPoint& sp, Vec3 wo, Rgb color) const {
    return wo.z < 0 && !thin_ && sp.transmission > 0 ? Rgb{} : color * (1 - sp.metallic);
  }
  static Ggx microfacets(const ShadingPoint& sp) {
    return Ggx(sp.roughness, Microfacets::kGgx, sp.anisotropy);
  }
  // Where the table of isotropic albedos is looked up. Up to an anisotropy of .6 a white dielectric
  // then returns all that arrives, but for 3 % more or 7 % less. At 1 it is up to 5 % more, and a
  // third less where grazing light comes from across (tests/stat/bsdf_energy_test.cpp).
  float roughness_along(const ShadingPoint& sp, Vec3 w) const {
    if (smooth_ || !(sp.anisotropy > 0)) return smooth_ ? 0 : sp.roughness;
    return microfacets(sp).roughness_along(w);
  }
  float mean_roughness(const ShadingPoint& sp) const {
    if (smooth_ || !(sp.anisotropy > 0)) return smooth_ ? 0 : sp.roughness;
    return microfacets(sp).mean_roughness();
  }
  Rgb dielectric_f0(const ShadingPoint& sp) const {
    const float from_index = sqr((ior_ - 1) / (ior_ + 1));
    Rgb f0;
    for (int i = 0; i < 3; ++i) f0[i] = std::min(from_index * sp.specular[i], 1.0f);
    return f0;
  }
  // Where wo is mirrored to the front.
  static Vec3 coat_normal(const ShadingPoint& sp, Vec3 wo) {
    const Vec3 n = sp.coat_normal;
    return wo.z < 0 ? Vec3{-n.x, -n.y, n.z} : n;
  }
  float coat_albedo(const ShadingPoint& sp, float cosine) const {
    if (sp.clearcoat <= 0 || cosine <= 0) return 0;
    const float roughness = smooth_coat_ ? 0 : sp.clearcoat_roughness;
    return sp.clearcoat * table_.at(roughness, cosine).of(kCoatF0, kCoatF90).r;
  }
  Rgb sheen_albedo(const ShadingPoint& sp, float cosine) const {
    if (!sheen_ || sp.sheen.is_black()) return {};
    return sp.sheen * sheen_->albedo(std::abs(cosine), sp.sheen_roughness);
  }
  // What the coat, and the sheen, leave to the layers below.
  float under_coat(const ShadingPoint& sp, const Layers& l, Vec3 wi) const {
    if (sp.clearcoat <= 0) return 1;
    return 1 - std::max(l.coat, coat_albedo(sp, dot(front(wi), coat_normal(sp, wi))));
  }
  float under_sheen(const ShadingPoint& sp, const Layers& l, Vec3 wi) const {
    if (!sheen_ || sp.sheen.is_black()) return 1;
    return 1 - std::max(l.sheen, max_component(sheen_albedo(sp, wi.z)));
  }

  float under(const ShadingPoint& sp, const Layers& l, Vec3 wi) const {
    return under_coat(sp, l, wi) * under_sheen(sp, l, wi);
  }

  // A microfacet of normal h, which is on wo's side: z is up where wo is.
  struct Facet {
    Rgb reflected, passed;
    float cos_o, cos_t;  // of what is bent; cos_t 0 under total reflection
    float reflect_chance;
  };
  Facet facet(const ShadingPoint& sp, const Layers& l, Vec3 wo, Vec3 h) const {
    Facet f;
    f.cos_o = dot(front(wo), h);
    f.cos_t = f.cos_o;
    float reflects_all = 0;
    const auto [all, of_dielectric] = fresnel(sp, l, f.cos_o);
    f.reflected = all;
    Rgb dielectric = of_dielectric;
    if (!thin_ && !l.passes.is_black()) {
      f.cos_t = fresnel_dielectric(f.cos_o, eta(wo)).cos_t;
      if (wo.z < 0) {  // Schlick's term wants the angle outside
        const Rgb inside = f.cos_t > 0 ? fresnel(sp, l, f.cos_t).dielectric : Rgb{1.0f};
        const float share = (1 - sp.metallic) * sp.transmission;
        f.reflected = disney_ ? inside * share : f.reflected + (inside - dielectric) * share;
        dielectric = inside;
      }
      reflects_all = f.cos_t > 0 ? 0.0f : 1.0f;
    }
    f.passed = l.passes * (1 - reflects_all) * (1 - max_component(dielectric));
    const float r = luminance(f.reflected), t = luminance(f.passed);
    f.reflect_chance = t > 0 ? r / (r + t) : 1;
    return f;
  }

  // What a facet reflects, by the cosine outside: of metal and dielectric together, and of the
  // dielectric.
  struct Fresnel {
    Rgb all, dielectric;
  };
  Fresnel fresnel(const ShadingPoint& sp, const Layers& l, float cosine) const {
    if (!film_ || !(sp.iridescence > 0))
      return {schlick(l.f0, l.f90, cosine), schlick(l.dielectric_f0, l.dielectric_f90, cosine)};
    const ThinFilm film(film_ior_, sp.film_nm);
    const auto with_film = [&](Rgb f0) {
      return lerp(sp.iridescence, schlick(f0, Rgb{1.0f}, cosine), film.reflectance(f0, cosine));
    };
    const Rgb dielectric = with_film(dielectric_f0(sp)) * sp.specular_weight;
    if (!(sp.metallic > 0)) return {dielectric, dielectric};
    return {lerp(sp.metallic, dielectric, with_film(sp.reflectance)), dielectric};
  }

  BsdfEval eval(const ShadingPoint& sp, const Layers& l, Vec3 wo, Vec3 wi) const {
    BsdfEval e;
    const Vec3 o = front(wo);
    const float coat_leaves = under_coat(sp, l, wi);
    const float under = coat_leaves * under_sheen(sp, l, wi);
    if (wo.z * wi.z > 0) {
      const Vec3 i{wi.x, wi.y, std::abs(wi.z)};
      const Vec3 h = normalize(o + i);
      if (l.coat > 0 && !smooth_coat_) add_coat(e, sp, l, Frame(coat_normal(sp, wo)), o, i, h);
      if (l.sheen_chance > 0) {
        e.f_cos += sp.sheen * (coat_leaves * sheen_->f(o, i, sp.sheen_roughness) * i.z);
        e.pdf_w += l.sheen_chance / (2 * kPi);
      }
      if (!smooth_) {
        const Ggx ggx = microfacets(sp);
        const Facet f = facet(sp, l, wo, h);
        const float d = 0.25f * ggx.d(h);
        e.f_cos += f.reflected * (under * d * ggx.g2_over_cos(o, i) * i.z);
        e.pdf_w += l.facet_chance * f.reflect_chance * d * ggx.g1_over_cos(o);
      }
      const float cosine = cosine_hemisphere_pdf_w(i.z);
      if (disney_) {
        const Burley terms(o, i, sp.roughness);
        e.base_f_cos =
            (l.diffuse * terms.diffuse + burley(sp, wo, sp.sheen) * terms.sheen) * (under * cosine);
      } else {
        e.base_f_cos = l.diffuse * (under * l.open * open(l, sp, i) * cosine);
      }
      e.base_pdf_w = l.diffuse_chance * cosine;
      e.f_cos += e.base_f_cos;
      e.pdf_w += e.base_pdf_w;
    } else {
      if (l.through_chance > 0) {
        const float cosine = cosine_hemisphere_pdf_w(std::abs(wi.z));
        e.f_cos += l.through * (under * l.open * open(l, sp, wi) * cosine);
        e.pdf_w += l.through_chance * cosine;
      }
      if (!smooth_ && !l.passes.is_black()) add_passed(e, sp, l, wo, wi, under);
    }
    return std::isfinite(e.pdf_w) ? e : BsdfEval{};
  }

  // 1 - E(wi).
  float open(const Layers& l, const ShadingPoint& sp, Vec3 wi) const {
    const GgxAlbedo::Value at = table_.at(roughness_along(sp, wi), std::abs(wi.z));
    return 1 - max_component(at.of(l.dielectric_f0, l.dielectric_f90));
  }

  void add_coat(BsdfEval& e, const ShadingPoint& sp, const Layers& l, const Frame& coat, Vec3 o,
                Vec3 i, Vec3 h) const {
    const Rgb f = schlick(kCoatF0, kCoatF90, dot(o, h));
    o = coat.to_local(o);
    i = coat.to_local(i);
    if (!(i.z > 0)) return;
    const Ggx ggx(sp.clearcoat_roughness);
    const float d = 0.25f * ggx.d(coat.to_local(h));
    e.f_cos += f * (sp.clearcoat * d * ggx.g2_over_cos(o, i) * i.z);
    e.pdf_w += l.coat_chance * d * ggx.g1_over_cos(o);
  }

  void add_passed(BsdfEval& e, const ShadingPoint& sp, const Layers& l, Vec3 wo, Vec3 wi,
                  float under) const {
    const Ggx ggx = microfacets(sp);
    const Vec3 o = front(wo);
    const float abs_cos_i = std::abs(wi.z);
    if (thin_) {  // reflected, then turned through the sheet
      const Vec3 i{wi.x, wi.y, abs_cos_i};
      const Vec3 h = normalize(o + i);
      const Facet f = facet(sp, l, wo, h);
      const float d = 0.25f * ggx.d(h);
      e.f_cos += f.passed * (under * d * ggx.g2_over_cos(o, i) * i.z);
      e.pdf_w += l.facet_chance * (1 - f.reflect_chance) * d * ggx.g1_over_cos(o);
      return;
    }
    // As dielectric.cpp: Walter et al. 2007, eq. 16, 17 and 21, over eta^2 for radiance.
    const float eta = this->eta(wo);
    const Vec3 i{wi.x, wi.y, -abs_cos_i};
    Vec3 h = o + i * eta;
    const float size = length(h);
    if (size == 0) return;
    h = h / std::copysign(size, h.z);
    const float cos_o = dot(o, h), cos_i = -dot(i, h);
    if (cos_o <= 0 || cos_i <= 0) return;
    const Facet f = facet(sp, l, wo, h);
    const float d = ggx.d(h) * cos_o * sqr(eta) * cos_i / sqr(eta * cos_i - cos_o);
    if (!std::isfinite(d)) return;
    e.f_cos += f.passed * (under * d * ggx.g2_over_cos(o, i) * abs_cos_i / sqr(eta));
    e.pdf_w += l.facet_chance * (1 - f.reflect_chance) * d * ggx.g1_over_cos(o);
  }

  static Rgb root(Rgb v) { return {std::sqrt(v.r), std::sqrt(v.g), std::sqrt(v.b)}; }
  static Rgb schlick(Rgb f0, Rgb f90, float cosine) {
    return lerp(schlick_weight(cosine), f0, f90);
  }
  static Vec3 front(Vec3 w) { return {w.x, w.y, std::abs(w.z)}; }
  // Back to wo's own side; z <= 0 there is below the surface.
  static Vec3 reflected(Vec3 wo, Vec3 h) {
    Vec3 wi = reflect(front(wo), h);
    wi.z *= std::copysign(1.0f, wo.z);
    return wi;
  }
  Vec3 passed(Vec3 wo, Vec3 h, const Facet& f) const {
    if (thin_) {
      Vec3 wi = reflected(wo, h);
      wi.z = -wi.z;
      return wi;
    }
    const float eta = this->eta(wo);
    Vec3 wi = h * (f.cos_o / eta - f.cos_t) - front(wo) / eta;
    wi.z *= std::copysign(1.0f, wo.z);
    return wi;
  }
  float eta(Vec3 wo) const { return wo.z > 0 ? ior_ : 1 / ior_; }

  static BsdfKind kind_of(const Material& m) {
    const bool lambert = m.metallic.texture.valid() || m.transmission.texture.valid() ||
                         (m.metallic.value < 1 && m.transmission.value < 1);
    const bool coat_has_density = !absent(m.clearcoat) && !absent(m.clearcoat_roughness);
    const bool coat_is_delta = !absent(m.clearcoat) && absent(m.clearcoat_roughness);
    const bool has_density = !is_smooth(m) || lambert || coat_has_density || !absent(m.sheen);
    if (!has_density) return BsdfKind::kDelta;
    return is_smooth(m) || coat_is_delta ? BsdfKind::kMixed : BsdfKind::kGlossy;
  }

  const GgxAlbedo& table_;
  const Sheen* sheen_;  // null: the material has none of glTF's
  float ior_, film_ior_;
  bool film_, disney_, thin_, smooth_, smooth_coat_;
  BsdfKind kind_;
};

}  // namespace

std::unique_ptr<Bsdf> make_principled(const Material& material) {
  return std::make_unique<Principled>(material);
}

}  // namespace qray
