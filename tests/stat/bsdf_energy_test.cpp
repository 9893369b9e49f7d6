// How much light a Bsdf sends back, and that it does so alike both ways.
#include <gtest/gtest.h>

#include "core/bsdf/burley.h"
#include "core/bsdf/fresnel.h"
#include "core/bsdf/ggx.h"
#include "core/bsdf/sheen.h"
#include "core/bsdf/thin_film.h"
#include "tests/support/bsdf_cases.h"
#include "tests/support/random.h"
#include "tests/support/stats.h"

namespace qray {
namespace {

constexpr int kSamples = 200'000;

// The mean weight of samples, in green. `flux` undoes the radiance's change across a boundary.
test::Moments mean_weight(const test::BsdfCase& c, Vec3 wo, uint64_t seed, bool flux = false,
                          int samples = kSamples) {
  test::Random random(seed);
  test::Moments mean;
  for (int i = 0; i < samples; ++i) {
    const float u_lobe = random.next();
    const auto s = c.bsdf->sample(c.at(wo), u_lobe, random.next_2d());
    double weight = s ? s->weight.g : 0.0;
    if (flux && s && s->wi.z * wo.z < 0 && c.material.kind != MaterialKind::kThinDielectric &&
        !c.material.thin)
      weight *= wo.z > 0 ? sqr(c.material.ior) : 1 / sqr(c.material.ior);
    mean.add(weight);
  }
  return mean;
}

Material white(MaterialKind kind, float roughness, float ior = 1.5f) {
  Material m = test::material_of(kind, roughness, ior);
  m.reflectance.value = Rgb{1};
  m.eta = Rgb{0.0f};  // a metal without loss: F = 1
  m.k = Rgb{3.0f};
  return m;
}

TEST(BsdfEnergy, NoSurfaceMakesLight) {
  for (const MaterialKind kind :
       {MaterialKind::kDiffuse, MaterialKind::kConductor, MaterialKind::kDielectric,
        MaterialKind::kThinDielectric, MaterialKind::kPlastic, MaterialKind::kPrincipled})
    for (const float roughness : {0.0f, 0.05f, 0.2f, 0.5f, 1.0f}) {
      const test::BsdfCase c = test::make_case("", white(kind, roughness));
      uint64_t seed = 1;
      for (const Vec3 wo : test::eye_directions()) {
        const test::Moments mean = mean_weight(c, wo, seed++, /*flux=*/true);
        EXPECT_LE(mean.mean(), 1 + 4 * mean.standard_error() + 2e-3)
            << static_cast<int>(kind) << " roughness " << roughness << " from " << test::text(wo);
      }
    }
}

// Every mixture of the principled kind's layers, white, from all sides: 576 means, so each of fewer
// samples than above.
TEST(BsdfEnergy, NoPrincipledSurfaceMakesLight) {
  int seed = 1;
  for (const float roughness : {0.0f, 0.15f, 0.5f, 1.0f})
    for (const float metallic : {0.0f, 0.5f, 1.0f})
      for (const float transmission : {0.0f, 0.5f, 1.0f})
        for (const float clearcoat : {0.0f, 1.0f})
          for (const bool thin : {false, true}) {
            Material m = white(MaterialKind::kPrincipled, roughness);
            m.metallic.value = metallic;
            m.transmission.value = transmission;
            m.clearcoat.value = clearcoat;
            m.clearcoat_roughness.value = seed % 2 == 0 ? 0.0f : 0.3f;
            m.specular.value = Rgb{seed % 3 == 0 ? 20.0f : 1.0f};
            m.thin = thin;
            const test::BsdfCase c = test::make_case("", m);
            for (const Vec3 wo : {test::direction(20, 50), test::direction(85, 10),
                                  test::direction(140, 70), test::direction(94, 120)}) {
              const test::Moments mean =
                  mean_weight(c, wo, static_cast<uint64_t>(seed++), true, kSamples / 4);
              EXPECT_LE(mean.mean(), 1 + 5 * mean.standard_error() + 2e-3)
                  << "roughness " << roughness << " metallic " << metallic << " transmission "
                  << transmission << " clearcoat " << clearcoat << " roughness "
                  << m.clearcoat_roughness.value << " thin " << thin << " from " << test::text(wo);
            }
          }
}

// Glass in two colours is the sum of what it reflects and what it passes, each by its own colour.
TEST(BsdfEnergy, GlassReflectsAndPassesByAColourEach) {
  for (const MaterialKind kind : {MaterialKind::kDielectric, MaterialKind::kThinDielectric})
    for (const float roughness : {0.0f, 0.4f}) {
      const auto mean = [&](float specular, float transmittance, Vec3 wo) {
        Material m = white(kind, roughness);
        m.specular.value.g = specular;
        m.transmittance.value.g = transmittance;
        return mean_weight(test::make_case("", m), wo, 3, /*flux=*/true);
      };
      for (const Vec3 wo : test::eye_directions()) {
        const test::Moments gloss = mean(1, 0, wo), passed = mean(0, 1, wo), both = mean(1, 1, wo),
                            tinted = mean(0.8f, 0.25f, wo);
        const double error = 4 * (gloss.standard_error() + passed.standard_error() +
                                  both.standard_error() + tinted.standard_error());
        const std::string at = (roughness > 0 ? "rough from " : "smooth from ") + test::text(wo);
        EXPECT_NEAR(gloss.mean() + passed.mean(), both.mean(), error + 1e-5) << at;
        EXPECT_NEAR(0.8 * gloss.mean() + 0.25 * passed.mean(), tinted.mean(), error + 1e-5) << at;
      }
      EXPECT_NEAR(mean(1, 0, {0, 0, 1}).mean(),
                  kind == MaterialKind::kDielectric ? 0.04 : 0.08 / 1.04, 2e-3);
    }
}

// White sheen over a white base, and over a black one, of which its albedo is the table's.
TEST(BsdfEnergy, SheenMakesNoLightAndTheBaseKeepsWhatItLeaves) {
  for (const float roughness : {0.0f, 0.1f, 0.3f, 0.6f, 1.0f}) {
    Material m = white(MaterialKind::kPrincipled, 0.5f);
    m.sheen.value = Rgb{1.0f};
    m.sheen_roughness.value = roughness;
    const test::BsdfCase over_white = test::make_case("", m);
    m.reflectance.value = Rgb{0.0f};
    m.specular_weight.value = 0;
    const test::BsdfCase alone = test::make_case("", m);
    for (const Vec3 wo : {test::direction(0, 0), test::direction(50, 10), test::direction(75, 80),
                          test::direction(86, 200), test::direction(120, 30)}) {
      const std::string at = "roughness " + std::to_string(roughness) + " from " + test::text(wo);
      const test::Moments all = mean_weight(over_white, wo, 3), sheen = mean_weight(alone, wo, 5);
      EXPECT_LE(all.mean(), 1 + 5 * all.standard_error() + 2e-3) << at;
      EXPECT_GT(all.mean(), 0.6) << at;
      const double table = static_cast<double>(Sheen::table().albedo(std::abs(wo.z), roughness));
      EXPECT_LE(sheen.mean(), table + 5 * sheen.standard_error() + 5e-3) << at;
      EXPECT_GT(sheen.mean(), 0.75 * table - 5e-3) << at;
    }
  }
}

TEST(BsdfEnergy, WhitePrincipledDielectricKeepsAll) {
  for (const float roughness : {0.0f, 0.1f, 0.4f, 1.0f})
    for (const float ior : {1.2f, 1.5f, 2.0f}) {
      const test::BsdfCase c =
          test::make_case("", white(MaterialKind::kPrincipled, roughness, ior));
      uint64_t seed = 1;
      for (const Vec3 wo : test::eye_directions()) {
        const test::Moments mean = mean_weight(c, wo, seed++);
        EXPECT_NEAR(mean.mean(), 1, 4 * mean.standard_error() + 4e-3)
            << "roughness " << roughness << " ior " << ior << " from " << test::text(wo);
      }
    }
  for (const bool thin : {false, true}) {
    Material m = white(MaterialKind::kPrincipled, 0);
    m.transmission.value = 1;
    m.thin = thin;
    const test::BsdfCase c = test::make_case("", m);
    for (const Vec3 wo : test::eye_directions())
      EXPECT_NEAR(mean_weight(c, wo, 5, /*flux=*/true).mean(), 1, 2e-3)
          << (thin ? "thin" : "solid") << " from " << test::text(wo);
  }
}

// Its diffuse part is Burley's whole, whatever facets reflect: neither is weighed by the other.
// What returns is told by burley.h in closed form, and by the facets over a black base.
TEST(BsdfEnergy, DisneysDiffuseIsBurleysWhole) {
  for (const float roughness : {0.2f, 0.5f, 1.0f}) {
    Material m = white(MaterialKind::kPrincipled, roughness);
    m.disney = true;
    const test::BsdfCase all = test::make_case("", m);
    m.reflectance.value = Rgb{0.0f};
    const test::BsdfCase facets = test::make_case("", m);
    m.specular_weight.value = 0;
    m.sheen.value = Rgb{1.0f};
    const test::BsdfCase sheen = test::make_case("", m);
    for (const Vec3 wo : {test::direction(0, 0), test::direction(50, 10), test::direction(75, 80),
                          test::direction(86, 200), test::direction(120, 30)}) {
      const float z = std::abs(wo.z);
      const test::Moments both = mean_weight(all, wo, 3), mirrored = mean_weight(facets, wo, 5),
                          fibres = mean_weight(sheen, wo, 7);
      const std::string at = std::to_string(roughness) + " from " + test::text(wo);
      EXPECT_NEAR(both.mean() - mirrored.mean(), static_cast<double>(Burley::albedo(z, roughness)),
                  5 * (both.standard_error() + mirrored.standard_error()) + 2e-3)
          << at;
      EXPECT_NEAR(fibres.mean(), static_cast<double>(Burley::sheen_albedo(z)),
                  5 * fibres.standard_error() + 0.01)
          << at;
    }
  }
}

// Its layers are weighed by the table of isotropic albedos, looked up by how rough it is along the
// direction. That is near where the anisotropy is moderate. At 1 and seen across, facets send
// grazing light aside that the table takes for mirrored.
TEST(BsdfEnergy, WhiteAnisotropicDielectricKeepsNearlyAll) {
  for (const float roughness : {0.1f, 0.4f, 0.7f})
    for (const float anisotropy : {0.4f, 0.6f, 1.0f}) {
      Material m = white(MaterialKind::kPrincipled, roughness);
      m.anisotropy.value = anisotropy;
      const test::BsdfCase c = test::make_case("", m);
      m.metallic.value = 1;
      const test::BsdfCase metal = test::make_case("", m);
      uint64_t seed = 1;
      for (const Vec3 wo : {test::direction(0, 0), test::direction(45, 5), test::direction(60, 85),
                            test::direction(80, 20), test::direction(88, 90)}) {
        const test::Moments mean = mean_weight(c, wo, seed, false, kSamples / 4);
        const test::Moments of_metal = mean_weight(metal, wo, seed++, false, kSamples / 4);
        const std::string at = "roughness " + std::to_string(roughness) + " anisotropy " +
                               std::to_string(anisotropy) + " from " + test::text(wo);
        const double off = anisotropy < 1 ? 0.03 : 0.06, dark = anisotropy < 1 ? 0.07 : 0.4;
        EXPECT_LT(mean.mean(), 1 + 4 * mean.standard_error() + off) << at;
        EXPECT_GT(mean.mean(), 1 - 4 * mean.standard_error() - dark) << at;
        EXPECT_LE(of_metal.mean(), 1 + 4 * of_metal.standard_error() + 2e-3) << at;
      }
    }
}

TEST(BsdfEnergy, PlasticThatIsNotNonlinearIsAsBrightAsItsBase) {
  // Under a field of light the base gives rho of what passes the coat, whatever rho.
  for (const float roughness : {0.0f, 0.3f, 0.8f})
    for (const float rho : {0.2f, 0.8f}) {
      Material m = white(MaterialKind::kPlastic, roughness);
      m.nonlinear = false;
      m.reflectance.value = Rgb{rho};
      const test::BsdfCase c = test::make_case("", m);
      m.reflectance.value = Rgb{0.0f};
      const test::BsdfCase coat = test::make_case("", m);
      for (const Vec3 wo : {test::direction(10, 0), test::direction(60, 200)}) {
        const test::Moments mean = mean_weight(c, wo, 7);
        const double passed = 1 - static_cast<double>(coat.bsdf->albedo(coat.at(wo)).g);
        const double base = mean.mean() - (1 - passed);
        EXPECT_NEAR(base, static_cast<double>(rho) * passed, 4 * mean.standard_error() + 4e-3)
            << roughness << " " << rho;
      }
    }
}

// Share of light from wo that one meeting with a GGX boundary of index `eta` sends back, or
// through.
double once(float cos_o, float eta, const Ggx& ggx, bool through) {
  test::Random random(1);
  const Vec3 wo{std::sqrt(1 - cos_o * cos_o), 0, cos_o};
  test::Moments mean;
  for (int i = 0; i < 20'000; ++i) {
    const Vec3 h = ggx.sample_visible(wo, random.next_2d());
    const float cosine = dot(wo, h);
    const DielectricFresnel f = fresnel_dielectric(cosine, eta);
    const Vec3 wi = through ? h * (cosine / eta - f.cos_t) - wo / eta : reflect(wo, h);
    const float share = through ? 1 - f.reflectance : f.reflectance;
    mean.add(through == (wi.z < 0) ? share * ggx.g2_over_g1(wo, wi) : 0.0f);
  }
  return mean.mean();
}

TEST(BsdfEnergy, RoughPlasticIsBrighterThanMitsubas) {
  // The figures of core/bsdf/README.md. Mitsuba's base: T(wo) T(wi) rho / (n^2 (1 - x R_in) pi), x
  // being rho or, not nonlinear, 1; T and R_in of a boundary that light meets once.
  constexpr float kIor = 1.49f, kRho = 0.5f;
  const struct {
    float alpha;
    double nonlinear, linear;
  } cases[] = {{0.1f, 0.98, 0.93}, {0.3f, 0.88, 0.72}, {0.5f, 0.79, 0.58}};
  for (const auto& c : cases) {
    const Ggx ggx(std::sqrt(c.alpha));
    double returned = 0;
    for (int i = 0; i < 100; ++i) {
      const float mu = (static_cast<float>(i) + 0.5f) / 100;
      returned += 2 * once(mu, 1 / kIor, ggx, false) * static_cast<double>(mu) / 100;
    }
    const double passed = once(1, kIor, ggx, true);
    for (const bool nonlinear : {true, false}) {
      Material m = test::material_of(MaterialKind::kPlastic, std::sqrt(c.alpha), kIor);
      m.nonlinear = nonlinear;
      m.reflectance.value = Rgb{kRho};
      m.specular.value = {};
      const test::BsdfCase plastic = test::make_case("", m);
      const double ours =
          static_cast<double>(plastic.bsdf->eval(plastic.at({0, 0, 1}), {0, 0, 1}).f_cos.g) *
          static_cast<double>(kPi);
      const double x = nonlinear ? static_cast<double>(kRho) : 1.0;
      const double mitsubas = passed * passed * static_cast<double>(kRho) /
                              (static_cast<double>(kIor * kIor) * (1 - x * returned));
      EXPECT_NEAR(mitsubas / ours, nonlinear ? c.nonlinear : c.linear, 0.007)
          << c.alpha << (nonlinear ? " nonlinear" : "");
    }
  }
}

TEST(BsdfEnergy, PaneReflectsAsASlab) {
  // Stokes: of index n straight on, one face sends back R = ((n - 1) / (n + 1))^2, both 2 R / (1 +
  // R).
  for (const float ior : {1.2f, 1.5f, 2.4f}) {
    const test::BsdfCase c = test::make_case("", white(MaterialKind::kThinDielectric, 0, ior));
    test::Random random(3);
    int back = 0;
    for (int i = 0; i < kSamples; ++i) {
      const auto s = c.bsdf->sample(c.at({0, 0, 1}), random.next(), {});
      ASSERT_TRUE(s && s->delta);
      if (s->wi.z > 0)
        ++back;
      else
        EXPECT_EQ(s->wi, (Vec3{0, 0, -1}));
    }
    const double n = static_cast<double>(ior), r = std::pow((n - 1) / (n + 1), 2);
    const double expected = 2 * r / (1 + r);
    EXPECT_NEAR(back / double{kSamples}, expected,
                5 * std::sqrt(expected * (1 - expected) / kSamples));
  }
}

TEST(BsdfEnergy, WhitePlasticReflectsAll) {
  for (const float roughness : {0.0f, 0.1f, 0.4f, 0.7f, 1.0f})
    for (const float ior : {1.2f, 1.5f, 2.0f}) {
      const test::BsdfCase c = test::make_case("", white(MaterialKind::kPlastic, roughness, ior));
      uint64_t seed = 1;
      for (const Vec3 wo : test::eye_directions()) {
        const test::Moments mean = mean_weight(c, wo, seed++);
        EXPECT_NEAR(mean.mean(), 1, 4 * mean.standard_error() + 4e-3)
            << "roughness " << roughness << " ior " << ior << " from " << test::text(wo);
      }
    }
}

// What one bounce keeps of GGX with F = 1 at normal incidence. With x = cos^2 of the normal's angle
// the visible normals have density a^2 / (1 + (a^2 - 1) x)^2 and light leaves at cos = 2 x - 1, so
// E = int_{1/2}^{1} a^2 / (1 + (a^2 - 1) x)^2 G1(2 x - 1) dx; for a = 1 it is 1 - ln 2.
double kept_at_normal_incidence(double alpha) {
  const double a2 = alpha * alpha;
  constexpr int kSteps = 400'000;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double x = 0.5 + 0.5 * (i + 0.5) / kSteps, c = 2 * x - 1;
    const double g1 = 2 / (1 + std::sqrt(1 + a2 * (1 / (c * c) - 1)));
    sum += a2 / std::pow(1 + (a2 - 1) * x, 2) * g1;
  }
  return 0.5 * sum / kSteps;
}

TEST(BsdfEnergy, LosslessMetalLosesOnlyWhatOneBounceMisses) {
  EXPECT_NEAR(kept_at_normal_incidence(1), 1 - std::log(2), 1e-6);
  const auto kept = [](float roughness, float theta_deg) {
    const test::BsdfCase c = test::make_case("", white(MaterialKind::kConductor, roughness));
    return mean_weight(c, test::direction(theta_deg, 30), 3);
  };
  for (const float roughness : {0.1f, 0.3f, 0.5f, 0.8f, 1.0f}) {
    const test::Moments mean = kept(roughness, 0);
    EXPECT_NEAR(mean.mean(), kept_at_normal_incidence(sqr(roughness)),
                4 * mean.standard_error() + 1e-4)
        << roughness;
  }
  // Grazing light meets its own shadow no more often than facets of slope alpha allow.
  for (const float theta_deg : {30.0f, 60.0f, 85.0f})
    EXPECT_GT(kept(0.1f, theta_deg).mean(), 0.97) << theta_deg;
}

TEST(BsdfEnergy, SmoothGlassAndLosslessMirrorKeepAll) {
  for (const float ior : {1.0f, 1.05f, 1.5f, 2.4f}) {
    for (const MaterialKind kind : {MaterialKind::kDielectric, MaterialKind::kThinDielectric}) {
      const test::BsdfCase glass = test::make_case("", white(kind, 0, ior));
      for (const Vec3 wo : test::eye_directions())
        EXPECT_NEAR(mean_weight(glass, wo, 5, /*flux=*/true).mean(), 1, 1e-5)
            << ior << " " << test::text(wo);
    }
  }
  const test::BsdfCase mirror = test::make_case("", white(MaterialKind::kConductor, 0));
  for (const Vec3 wo : test::eye_directions())
    EXPECT_NEAR(mean_weight(mirror, wo, 5).mean(), 1, 1e-5);
}

TEST(BsdfEnergy, AlbedoIsTheMeanWeightOfPlastic) {
  for (const float roughness : {0.0f, 0.3f, 1.0f}) {
    const test::BsdfCase c =
        test::make_case("", test::material_of(MaterialKind::kPlastic, roughness));
    uint64_t seed = 1;
    for (const Vec3 wo : test::eye_directions()) {
      const test::Moments mean = mean_weight(c, wo, seed++);
      EXPECT_NEAR(mean.mean(), c.bsdf->albedo(c.at(wo)).g, 4 * mean.standard_error() + 4e-3)
          << roughness << " " << test::text(wo);
    }
  }
}

TEST(BsdfEnergy, OpaqueKindsAndReflectionAreReciprocal) {
  test::Random random(11);
  for (const test::BsdfCase& c : test::density_cases()) {
    if (!c.reciprocal) continue;
    for (int i = 0; i < 2000; ++i) {
      const auto draw = [&] {
        const Vec2 u = random.next_2d();
        const float z = 0.02f + 0.98f * u.x, r = std::sqrt(1 - z * z), phi = 2 * kPi * u.y;
        return Vec3{r * std::cos(phi), r * std::sin(phi), z};
      };
      const Vec3 a = draw(), b = draw();
      const Rgb ab = c.bsdf->eval(c.at(a), b).f_cos / b.z;
      const Rgb ba = c.bsdf->eval(c.at(b), a).f_cos / a.z;
      for (int channel = 0; channel < 3; ++channel)
        EXPECT_NEAR(ab[channel], ba[channel], 2e-3f * std::abs(ab[channel]) + 1e-6f)
            << c.name << " " << test::text(a) << " " << test::text(b);
    }
  }
}

// All of white light that enters a white leaf leaves it, on one side or the other, and it does not
// matter which side it comes from.
TEST(BsdfEnergy, WhiteLeafKeepsAllAndIsReciprocalThrough) {
  test::Random random(13);
  for (const float roughness : {0.0f, 0.4f})
    for (const float share : {0.5f, 1.0f}) {
      Material m = white(MaterialKind::kPrincipled, roughness);
      m.thin = true;
      m.diffuse_transmission.value = share;
      const test::BsdfCase c = test::make_case("", m);
      for (const Vec3 wo : test::eye_directions()) {
        const test::Moments mean = mean_weight(c, wo, 5);
        EXPECT_NEAR(mean.mean(), 1, 4 * mean.standard_error() + 4e-3)
            << roughness << " " << share << " from " << test::text(wo);
      }
      for (int i = 0; i < 500; ++i) {
        const Vec3 a = test::direction(85 * random.next(), 360 * random.next());
        const Vec3 b = test::direction(180 - 85 * random.next(), 360 * random.next());
        const float down = c.bsdf->eval(c.at(a), b).f_cos.g / -b.z;
        const float up = c.bsdf->eval(c.at(b), a).f_cos.g / a.z;
        EXPECT_GT(down, 0);
        EXPECT_NEAR(down, up, 1e-4f * down) << test::text(a) << test::text(b);
      }
    }
}

// A film's layers are weighed by its mean over the angles, so that a white base under it returns
// all that arrives but for a few percent; metal under it loses what it does without.
TEST(BsdfEnergy, WhiteBaseUnderAFilmKeepsNearlyAll) {
  for (const float roughness : {0.0f, 0.3f, 0.8f})
    for (const float film_ior : {1.0f, 1.33f, 2.0f})
      for (const float nm : {0.0f, 120.0f, 300.0f, 800.0f}) {
        Material m = white(MaterialKind::kPrincipled, roughness);
        m.iridescence.value = 1;
        m.film_ior = film_ior;
        m.film_nm.value = nm;
        const test::BsdfCase c = test::make_case("", m);
        m.metallic.value = 1;
        const test::BsdfCase metal = test::make_case("", m);
        uint64_t seed = 1;
        for (const Vec3 wo : {test::direction(0, 0), test::direction(45, 5),
                              test::direction(70, 85), test::direction(85, 20)}) {
          const test::Moments mean = mean_weight(c, wo, seed, false, kSamples / 25);
          const test::Moments of_metal = mean_weight(metal, wo, seed++, false, kSamples / 25);
          const std::string at = "roughness " + std::to_string(roughness) + " film " +
                                 std::to_string(film_ior) + " of " + std::to_string(nm) +
                                 " nm from " + test::text(wo);
          EXPECT_LT(mean.mean(), 1 + 4 * mean.standard_error() + 0.06) << at;
          EXPECT_GT(mean.mean(), 1 - 4 * mean.standard_error() - 0.2) << at;
          EXPECT_LE(of_metal.mean(), 1 + 4 * of_metal.standard_error() + 2e-3) << at;
        }
      }
}

TEST(BsdfEnergy, ATiltedCoatMakesNoLight) {
  for (const float roughness : {0.0f, 0.3f})
    for (const float tilt_deg : {10.0f, 30.0f}) {
      Material m = white(MaterialKind::kPrincipled, 0.5f);
      m.clearcoat.value = 1;
      m.clearcoat_roughness.value = roughness;
      test::BsdfCase c = test::make_case("", m);
      c.point.coat_normal = test::direction(tilt_deg, 40);
      for (const Vec3 wo : test::eye_directions()) {
        const test::Moments mean = mean_weight(c, wo, 7, false, kSamples / 4);
        EXPECT_LE(mean.mean(), 1 + 4 * mean.standard_error() + 2e-3)
            << roughness << " tilted by " << tilt_deg << " from " << test::text(wo);
      }
    }
}

TEST(BsdfEnergy, RefractionIsReciprocalUpToTheIndexSquared) {
  // Veach 1997, eq. 5.14: f(wi -> wo) / n_wo^2 is the same both ways.
  test::Random random(12);
  Material principled = test::material_of(MaterialKind::kPrincipled, 0.6f);
  principled.transmission.value = 1;
  for (const Material& m : {test::material_of(MaterialKind::kDielectric, 0.6f), principled}) {
    const test::BsdfCase c = test::make_case("", m);
    int lit = 0;
    for (int i = 0; i < 20'000; ++i) {
      const float u_lobe = random.next();
      const Vec3 wo = test::direction(85 * random.next(), 360 * random.next());
      const auto s = c.bsdf->sample(c.at(wo), u_lobe, random.next_2d());
      if (!s || s->wi.z > -0.02f) continue;
      ++lit;
      const float down = c.bsdf->eval(c.at(wo), s->wi).f_cos.g / -s->wi.z;
      const float up = c.bsdf->eval(c.at(s->wi), wo).f_cos.g / wo.z;
      EXPECT_NEAR(up / down, 1.5f * 1.5f, 0.01f) << test::text(wo) << test::text(s->wi);
    }
    EXPECT_GT(lit, 5000);
  }
}

}  // namespace
}  // namespace qray
