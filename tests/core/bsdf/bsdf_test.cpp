#include "core/bsdf/bsdf.h"

#include <gtest/gtest.h>

#include "core/bsdf/fresnel.h"
#include "core/bsdf/ggx.h"
#include "tests/support/bsdf_cases.h"
#include "tests/support/random.h"

namespace qray {
namespace {

TEST(Fresnel, DielectricKnownValues) {
  // ((n-1)/(n+1))^2 at normal incidence, 1 at grazing, 0 for parallel light at Brewster's angle.
  EXPECT_NEAR(fresnel_dielectric(1, 1.5f).reflectance, 0.04, 1e-6);
  EXPECT_NEAR(fresnel_dielectric(1, 1 / 1.5f).reflectance, 0.04, 1e-6);
  EXPECT_NEAR(fresnel_dielectric(0, 1.5f).reflectance, 1, 1e-6);
  const float brewster = std::cos(std::atan(1.5f));
  const float perpendicular = sqr((1 - 1.5f * 1.5f) / (1 + 1.5f * 1.5f));  // of the one half
  EXPECT_NEAR(fresnel_dielectric(brewster, 1.5f).reflectance, perpendicular / 2, 1e-5);
  EXPECT_EQ(fresnel_dielectric(0.7f, 1 / 1.5f).reflectance, 1);  // sin = .71 > 1/1.5
  EXPECT_NEAR(fresnel_dielectric(0.3f, 1.0f).reflectance, 0, 1e-12);
}

TEST(Fresnel, MeanOfGlassIsTheTabulatedOne) {
  EXPECT_NEAR(mean_fresnel_dielectric(1.5f), 0.0918, 2e-4);  // Egan and Hilgeman 1973
  // Light inside a diffuse field: (1 - R_in) n^2 = 1 - R_out.
  const float inside = mean_fresnel_dielectric(1 / 1.5f), outside = mean_fresnel_dielectric(1.5f);
  EXPECT_NEAR((1 - inside) * 1.5f * 1.5f, 1 - outside, 2e-3);
}

TEST(Fresnel, ConductorKnownValues) {
  // ((n-1)^2 + k^2) / ((n+1)^2 + k^2) at normal incidence; no k: glass.
  EXPECT_NEAR(fresnel_conductor(1, 0.2f, 3.9f), (0.64 + 15.21) / (1.44 + 15.21), 1e-5);
  EXPECT_NEAR(fresnel_conductor(0, 0.2f, 3.9f), 1, 1e-5);
  for (const float cosine : {0.1f, 0.5f, 0.9f, 1.0f})
    EXPECT_NEAR(fresnel_conductor(cosine, 1.5f, 0), fresnel_dielectric(cosine, 1.5f).reflectance,
                1e-5);
  for (const float cosine : {0.0f, 0.3f, 1.0f})
    EXPECT_NEAR(fresnel_conductor(cosine, 0, 0), 1, 1e-6);  // nothing enters index 0
}

TEST(Ggx, NormalsCoverTheirArea) {
  // int d(h) cos(h) dh = 1, by the midpoint rule in tan^2-like steps.
  for (const float roughness : {0.1f, 0.4f, 1.0f}) {
    const Ggx ggx(roughness);
    double sum = 0;
    constexpr int kSteps = 200'000;
    for (int i = 0; i < kSteps; ++i) {
      const double t = (i + 0.5) / kSteps, theta = t * t * kPi / 2;  // dense near the normal
      const double jacobian = 2 * t * kPi / 2 / kSteps;
      const Vec3 h{static_cast<float>(std::sin(theta)), 0, static_cast<float>(std::cos(theta))};
      sum += ggx.d(h) * std::cos(theta) * std::sin(theta) * 2 * kPi * jacobian;
    }
    EXPECT_NEAR(sum, 1, 1e-3) << roughness;
  }
}

// Straight on nothing is shadowed and what is drawn has the density D cos: the mean weight is the
// integral of Beckmann's own D cos, 1.
TEST(Ggx, BeckmannsNormalsCoverTheirArea) {
  const Vec3 up{0, 0, 1};
  for (const float roughness : {0.1f, 0.3f}) {
    const Ggx ggx(roughness, Microfacets::kBeckmann);
    double sum = 0;
    constexpr int kSteps = 400;
    for (int i = 0; i < kSteps * kSteps; ++i) {
      const Vec3 h = ggx.sample(up, {(static_cast<float>(i / kSteps) + 0.5f) / kSteps,
                                     (static_cast<float>(i % kSteps) + 0.5f) / kSteps});
      sum += static_cast<double>(ggx.weight(h, up, reflect(up, h)));
    }
    EXPECT_NEAR(sum / (kSteps * kSteps), 1, 2e-3) << roughness;
  }
}

// Seen straight on, slopes in x are to those in y as the alphas are.
TEST(Ggx, AnisotropyStretchesSlopesAlongX) {
  const float anisotropy = 0.6f, roughness = 0.5f;
  const float alpha_y = sqr(roughness), alpha_x = lerp(sqr(anisotropy), alpha_y, 1.0f);
  for (const Microfacets microfacets : {Microfacets::kGgx, Microfacets::kBeckmann}) {
    const Ggx ggx(roughness, microfacets, anisotropy);
    std::vector<float> x, y;
    double sum = 0;
    constexpr int kSteps = 300;
    const Vec3 up{0, 0, 1};
    for (int i = 0; i < kSteps * kSteps; ++i) {
      const Vec3 h = ggx.sample(up, {(static_cast<float>(i / kSteps) + 0.5f) / kSteps,
                                     (static_cast<float>(i % kSteps) + 0.5f) / kSteps});
      x.push_back(std::abs(h.x / h.z));
      y.push_back(std::abs(h.y / h.z));
      if (microfacets == Microfacets::kBeckmann) {
        const Vec3 wi = reflect(up, h);
        if (wi.z > 0) sum += static_cast<double>(ggx.weight(h, up, wi));
      }
    }
    const auto middle = [](std::vector<float>& v) {
      std::nth_element(v.begin(), v.begin() + std::ssize(v) / 2, v.end());
      return v[v.size() / 2];
    };
    EXPECT_NEAR(middle(x) / middle(y), alpha_x / alpha_y, 0.03f);
    EXPECT_NEAR(ggx.roughness_along({1, 0, 0}), std::sqrt(alpha_x), 1e-5f);
    EXPECT_NEAR(ggx.roughness_along({0, 1, 0}), roughness, 1e-5f);
    EXPECT_LE(sum, kSteps * kSteps);
  }
}

TEST(Bsdf, KindsFollowTheMaterial) {
  const auto kind = [](MaterialKind k, float roughness, float ior = 1.5f) {
    return make_bsdf(test::material_of(k, roughness, ior))->kind();
  };
  EXPECT_EQ(kind(MaterialKind::kDiffuse, 0), BsdfKind::kDiffuse);
  EXPECT_EQ(kind(MaterialKind::kConductor, 0), BsdfKind::kDelta);
  EXPECT_EQ(kind(MaterialKind::kConductor, 0.2f), BsdfKind::kGlossy);
  EXPECT_EQ(kind(MaterialKind::kDielectric, 0), BsdfKind::kDelta);
  EXPECT_EQ(kind(MaterialKind::kDielectric, 0.2f), BsdfKind::kGlossy);
  EXPECT_EQ(kind(MaterialKind::kDielectric, 0.2f, 1.0f), BsdfKind::kDelta);  // no boundary
  EXPECT_EQ(kind(MaterialKind::kPlastic, 0), BsdfKind::kMixed);
  EXPECT_EQ(kind(MaterialKind::kPlastic, 0.2f), BsdfKind::kGlossy);
  EXPECT_EQ(kind(MaterialKind::kThinDielectric, 0), BsdfKind::kDelta);
  EXPECT_EQ(make_bsdf(test::material_of(MaterialKind::kBlend, 0)), nullptr);
}

TEST(Bsdf, PrincipledKindsFollowItsConstants) {
  const auto kind = [](float roughness, auto change) {
    Material m = test::material_of(MaterialKind::kPrincipled, roughness);
    change(m);
    return make_bsdf(m)->kind();
  };
  const auto none = [](Material&) {};
  const auto metal = [](Material& m) { m.metallic.value = 1; };
  const auto glass = [](Material& m) { m.transmission.value = 1; };
  const auto varying_metal = [](Material& m) { m.metallic = {1, TextureId{0}}; };
  const auto coat = [](Material& m) { m.clearcoat.value = 1; };
  const auto coated_metal = [](Material& m) {
    m.metallic.value = m.clearcoat.value = 1;
    m.clearcoat_roughness.value = 0.1f;
  };
  EXPECT_EQ(kind(0.5f, none), BsdfKind::kGlossy);
  EXPECT_EQ(kind(0, none), BsdfKind::kMixed);
  EXPECT_EQ(kind(0, metal), BsdfKind::kDelta);
  EXPECT_EQ(kind(0, glass), BsdfKind::kDelta);
  EXPECT_EQ(kind(0, varying_metal), BsdfKind::kMixed);
  EXPECT_EQ(kind(0.5f, coat), BsdfKind::kMixed);
  EXPECT_EQ(kind(0, coated_metal), BsdfKind::kMixed);
  EXPECT_EQ(kind(0.5f, coated_metal), BsdfKind::kGlossy);
}

TEST(Bsdf, WeightIsValueOverDensity) {
  test::Random random(3);
  for (const test::BsdfCase& c : test::density_cases())
    for (const Vec3 wo : test::eye_directions())
      for (int i = 0; i < 300; ++i) {
        const float u_lobe = random.next();
        const auto s = c.bsdf->sample(c.at(wo), u_lobe, random.next_2d());
        if (!s || s->delta) continue;
        // A microfacet at the edge of its lobe amplifies the rounding of wi.
        const BsdfEval e = c.bsdf->eval(c.at(wo), s->wi);
        ASSERT_NEAR(e.pdf_w, s->pdf_w, 0.01f * s->pdf_w) << c.name << " " << test::text(wo);
        for (int channel = 0; channel < 3; ++channel)
          ASSERT_NEAR(e.f_cos[channel], s->weight[channel] * s->pdf_w,
                      0.02f * e.f_cos[channel] + 1e-6f)
              << c.name << " " << test::text(wo) << " " << test::text(s->wi);
      }
}

TEST(Bsdf, SmoothGlassObeysSnell) {
  const test::BsdfCase c = test::make_case("", test::material_of(MaterialKind::kDielectric, 0));
  for (const Vec3 wo : {test::direction(30, 40), test::direction(170, 100)}) {
    const float eta = wo.z > 0 ? 1.5f : 1 / 1.5f;
    const auto s = c.bsdf->sample(c.at(wo), 0.999f, {0.5f, 0.5f});
    ASSERT_TRUE(s && s->delta);
    EXPECT_LT(s->wi.z * wo.z, 0);
    EXPECT_NEAR(s->wi.x, -wo.x / eta, 1e-6);
    EXPECT_NEAR(s->wi.y, -wo.y / eta, 1e-6);
    EXPECT_NEAR(s->weight.g, 1 / sqr(eta), 1e-5);
    const auto mirror = c.bsdf->sample(c.at(wo), 0.0f, {0.5f, 0.5f});
    ASSERT_TRUE(mirror && mirror->delta);
    EXPECT_EQ(mirror->wi, (Vec3{-wo.x, -wo.y, wo.z}));
    EXPECT_NEAR(mirror->weight.g, 1, 1e-6);
  }
}

TEST(Bsdf, ATexturesZeroRoughnessIsAlmostSmooth) {
  for (const MaterialKind kind : {MaterialKind::kConductor, MaterialKind::kDielectric,
                                  MaterialKind::kPlastic, MaterialKind::kPrincipled}) {
    Material m = test::material_of(kind, 0.5f);
    m.roughness.texture = TextureId{0};
    const std::unique_ptr<Bsdf> bsdf = make_bsdf(m);
    const ShadingPoint sp{m.reflectance.value, 0.0f};
    const Vec3 wo = test::direction(40, 0);
    const auto s = bsdf->sample(bsdf->at(sp, wo), 0.0f, {0.3f, 0.3f});
    ASSERT_TRUE(s.has_value());
    EXPECT_FALSE(s->delta);
    EXPECT_GT(dot(s->wi, {-wo.x, -wo.y, wo.z}), 0.9999f);
    EXPECT_TRUE(std::isfinite(s->pdf_w) && is_finite(s->weight));
  }
}

// Each of the principled kind's shares at an end of its range or within.
void mix_layers(test::Random& random, Material& m) {
  for (FloatParam* p :
       {&m.metallic, &m.transmission, &m.clearcoat, &m.clearcoat_roughness, &m.specular_weight})
    p->value = std::clamp(2 * random.next() - 0.5f, 0.0f, 1.0f);
  m.specular.value = Rgb{random.next() < 0.5f ? 1.0f : 30.0f};
  m.thin = random.next() < 0.5f;
}

// Whatever the directions and numbers: finite, not negative, unit directions, no density below.
TEST(Bsdf, NothingBreaksItsNumbers) {
  test::Random random(5);
  const float tiny[] = {0.0f, 1e-38f, 1e-20f, 1e-7f, 1e-3f};
  const float edges[] = {0.0f, 0x1p-24f, 0.5f, 0x1.fffffep-1f};
  for (const MaterialKind kind :
       {MaterialKind::kDiffuse, MaterialKind::kConductor, MaterialKind::kDielectric,
        MaterialKind::kThinDielectric, MaterialKind::kPlastic, MaterialKind::kPrincipled})
    for (const float roughness : {0.0f, 1e-4f, 0.01f, 0.03f, 0.2f, 1.0f})
      for (const float ior : {1.0f, 1.002f, 1.5f, 4.0f}) {
        Material m = test::material_of(kind, roughness, ior);
        m.nonlinear = random.next() < 0.5f;
        if (kind == MaterialKind::kPrincipled) mix_layers(random, m);
        const test::BsdfCase c = test::make_case("", m);
        for (int i = 0; i < 3000; ++i) {
          float z = i % 3 == 0 ? tiny[i / 3 % 5] : 2 * random.next() - 1;
          if (i % 2 == 0) z = -z;
          const float phi = 2 * kPi * random.next(), r = std::sqrt(std::max(0.0f, 1 - z * z));
          const Vec3 wo{r * std::cos(phi), r * std::sin(phi), z};
          Vec2 u = random.next_2d();
          float u_lobe = random.next();
          if (i % 5 == 0) {
            u = {edges[random.next_u32() % 4], edges[random.next_u32() % 4]};
            u_lobe = edges[random.next_u32() % 4];
          }
          const auto s = c.bsdf->sample(c.at(wo), u_lobe, u);
          const std::string where = std::to_string(static_cast<int>(kind)) + " roughness " +
                                    std::to_string(roughness) + " ior " + std::to_string(ior) +
                                    " " + test::text(wo);
          Vec3 wi = test::direction(180 * random.next(), 360 * random.next());
          if (s) {
            ASSERT_TRUE(is_finite(s->weight) && std::isfinite(s->pdf_w)) << where;
            ASSERT_GE(std::min({s->weight.r, s->weight.g, s->weight.b}), 0) << where;
            ASSERT_LT(max_component(s->weight), 30.0f) << where;
            ASSERT_NEAR(length(s->wi), 1, 1e-4) << where;
            ASSERT_TRUE(s->delta ? s->pdf_w == 0 : s->pdf_w > 0) << where;
            if (i % 4 == 0) wi = s->wi;
          }
          const BsdfEval e = c.bsdf->eval(c.at(wo), wi);
          ASSERT_TRUE(is_finite(e.f_cos) && std::isfinite(e.pdf_w)) << where << test::text(wi);
          ASSERT_GE(std::min({e.pdf_w, e.f_cos.r, e.f_cos.g, e.f_cos.b}), 0) << where;
          if (kind != MaterialKind::kDielectric && m.transmission.value == 0 && wo.z * wi.z < 0) {
            ASSERT_EQ(e.pdf_w, 0) << where;
          }
          const Rgb albedo = c.bsdf->albedo(c.at(wo));
          ASSERT_TRUE(is_finite(albedo) && max_component(albedo) <= 1.0001f) << where;
        }
      }
}

}  // namespace
}  // namespace qray
