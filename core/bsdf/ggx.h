// The GGX microfacet distribution with height-correlated Smith shadowing (Walter et al. 2007; Heitz
// 2014, eq. 99) and visible-normal sampling by spherical caps (Dupuy and Benyoub 2023). With
// anisotropy it is the isotropic one stretched along x (Heitz 2014, section 5.3).
// Terms are arranged so that nothing is divided by a cosine: products stay finite at grazing
// angles. wo is on the +z side. Beckmann's normals are drawn as they are where hardly any is hidden
// from wo (Walter et al. 2007, eq. 28 and 29). Elsewhere they are drawn by GGX's visible normals of
// the same alpha, which are never much rarer: its density is at most 4 / e of theirs. Any thread.
#pragma once

#include "core/math/vec.h"
#include "core/scene/material.h"

namespace qray {

class Ggx {
 public:
  static constexpr float kMinAlpha = 1e-3f;
  static constexpr float kSteep = 4;  // cotangents of wo, over alpha, from which on all are drawn

  // Both as Material's, in [0, 1]; a texture's zero is taken as almost smooth.
  explicit Ggx(float roughness, Microfacets microfacets = Microfacets::kGgx, float anisotropy = 0)
      : alpha_(std::clamp(sqr(roughness), kMinAlpha, 1.0f)),
        alpha2_(sqr(alpha_)),
        is_beckmann_(microfacets == Microfacets::kBeckmann) {
    if (!(anisotropy > 0)) return;
    const float alpha_x = lerp(sqr(std::min(anisotropy, 1.0f)), alpha_, 1.0f);
    stretch2_ = alpha_x / alpha_;
    squeeze2_ = 1 / stretch2_;
    stretch_ = std::sqrt(stretch2_);
    alpha2_ = alpha_x * alpha_;
    alpha_ = std::sqrt(alpha2_);
  }

  // Density of microfacet area over normals.
  float d(Vec3 h) const {
    const float t = alpha2_ * h.z * h.z + unstretched2(h);
    return alpha2_ * kInvPi / sqr(t);
  }
  // |w.z| sqrt(1 + alpha^2 tan^2): shadowing is made of these.
  float slope_term(Vec3 w) const { return std::sqrt(w.z * w.z + alpha2_ * stretched2(w)); }
  // Shadowing of one direction, over its cosine: G1(w) / |w.z|.
  float g1_over_cos(Vec3 w) const { return 2 / (std::abs(w.z) + slope_term(w)); }
  // Joint shadowing, over both cosines: G2(wo, wi) / |wo.z wi.z|.
  float g2_over_cos(Vec3 wo, Vec3 wi) const {
    const float zo = std::abs(wo.z), zi = std::abs(wi.z);
    return 2 / (zo * slope_term(wi) + zi * slope_term(wo));
  }
  // G2(wo, wi) / G1(wo): the weight of a visible-normal sample. At most 1.
  float g2_over_g1(Vec3 wo, Vec3 wi) const {
    const float zo = std::abs(wo.z), zi = std::abs(wi.z);
    const float so = slope_term(wo), si = slope_term(wi);
    return zi * (zo + so) / (zo * si + zi * so);
  }

  // D(h) G2(wo, wi) / |wo.z wi.z|, of the distribution that is asked for.
  float d_g2_over_cos(Vec3 h, Vec3 wo, Vec3 wi) const {
    if (!is_beckmann_) return d(h) * g2_over_cos(wo, wi);
    return beckmann_d(h) * beckmann_g1_over_cos(wo) * beckmann_g1_over_cos(wi);
  }
  // The weight of a sample, Fresnel's terms apart.
  float weight(Vec3 h, Vec3 wo, Vec3 wi) const {
    if (!is_beckmann_) return g2_over_g1(wo, wi);
    return d_g2_over_cos(h, wo, wi) * std::abs(wi.z) / density_over_cos(h, wo);
  }

  // A normal, of density density_over_cos() |wo . h| per steradian.
  Vec3 sample(Vec3 wo, Vec2 u) const {
    if (!draws_all(wo)) return sample_visible(wo, u);
    const float slope = alpha_ * std::sqrt(-std::log(1 - u.y)), phi = 2 * kPi * u.x;
    return normalize(
        Vec3{slope * stretch_ * std::cos(phi), slope / stretch_ * std::sin(phi), 1.0f});
  }
  float density_over_cos(Vec3 h, Vec3 wo) const {
    if (draws_all(wo)) return beckmann_d(h) * h.z / std::abs(dot(wo, h));
    return d(h) * g1_over_cos(wo);
  }
  // A normal seen from wo by GGX, density d(h) g1_over_cos(wo) |wo . h| per steradian.
  Vec3 sample_visible(Vec3 wo, Vec2 u) const {
    const float alpha_x = alpha_ * stretch_, alpha_y = alpha_ / stretch_;
    const Vec3 v = normalize(Vec3{alpha_x * wo.x, alpha_y * wo.y, wo.z});
    const float phi = 2 * kPi * u.x;
    const float z = (1 - u.y) * (1 + v.z) - v.z;
    const float r = std::sqrt(std::clamp(1 - z * z, 0.0f, 1.0f));
    const Vec3 cap = Vec3{r * std::cos(phi), r * std::sin(phi), z} + v;
    const Vec3 h{alpha_x * cap.x, alpha_y * cap.y, std::max(cap.z, 1e-12f)};
    return normalize(h);
  }

  // Of the isotropic distribution that is as rough along w, and of the one as rough on the whole.
  float roughness_along(Vec3 w) const {
    const float sin2 = w.x * w.x + w.y * w.y;
    return std::sqrt(sin2 > 0 ? alpha_ * std::sqrt(stretched2(w) / sin2) : alpha_);
  }
  float mean_roughness() const { return std::sqrt(alpha_); }

 private:
  // Sines of w squared, its x stretched or the reverse, and its y the other way.
  float stretched2(Vec3 w) const { return w.x * w.x * stretch2_ + w.y * w.y * squeeze2_; }
  float unstretched2(Vec3 w) const { return w.x * w.x * squeeze2_ + w.y * w.y * stretch2_; }
  // Slopes are at most about three alpha, and one over this is what hides them.
  bool draws_all(Vec3 wo) const {
    return is_beckmann_ && sqr(wo.z) > sqr(kSteep) * alpha2_ * stretched2(wo);
  }
  float beckmann_d(Vec3 h) const {
    const float z2 = h.z * h.z, exponent = unstretched2(h) / (alpha2_ * z2);
    if (!(exponent < 80)) return 0;  // no float is left, nor need z2 be
    return std::exp(-exponent) * kInvPi / (alpha2_ * z2 * z2);
  }
  // Walter et al. 2007, after eq. 27, with its a = |w.z| / s.
  float beckmann_g1_over_cos(Vec3 w) const {
    const float z = std::abs(w.z), s = alpha_ * std::sqrt(stretched2(w));
    if (z >= 1.6f * s) return 1 / z;
    return (3.535f * s + 2.181f * z) / (s * s + 2.276f * s * z + 2.577f * z * z);
  }

  float alpha_, alpha2_;  // the geometric mean of both directions' alpha, and its square
  // alpha_x = alpha_ * stretch_, alpha_y = alpha_ / stretch_; its square, and one over that.
  float stretch_ = 1, stretch2_ = 1, squeeze2_ = 1;
  bool is_beckmann_;
};

// The mirror image of w about h.
inline Vec3 reflect(Vec3 w, Vec3 h) { return h * (2 * dot(w, h)) - w; }

}  // namespace qray
