// Directions that a Bsdf samples follow the density that it tells.
#include <gtest/gtest.h>

#include "tests/support/bsdf_cases.h"
#include "tests/support/chi2.h"
#include "tests/support/stats.h"

namespace qray {
namespace {

// A delta direction is an outcome without density, as absorption is.
test::Chi2 chi2(const test::BsdfCase& c, Vec3 wo, uint64_t seed) {
  test::Chi2Options options;
  options.seed = seed;
  options.samples = 100'000;
  options.tolerance = 1e-6;  // a tenth of a sample
  return test::chi2_sphere(
      [&](test::Random& random) -> std::optional<Vec3> {
        const float u_lobe = random.next();
        const auto s = c.bsdf->sample(c.at(wo), u_lobe, random.next_2d());
        return s && !s->delta ? std::optional(s->wi) : std::nullopt;
      },
      [&](Vec3 wi) { return c.bsdf->eval(c.at(wo), wi).pdf_w; }, options);
}

TEST(BsdfChi2, SamplesFollowTheDensity) {
  const std::vector<test::BsdfCase> cases = test::density_cases();
  const std::vector<Vec3> eyes = test::eye_directions();
  const double level = test::significance(static_cast<int>(cases.size() * eyes.size()));
  uint64_t seed = 1;
  for (const test::BsdfCase& c : cases)
    for (const Vec3 wo : eyes) {
      const test::Chi2 result = chi2(c, wo, seed++);
      EXPECT_GT(result.p_value, level) << c.name << " from " << test::text(wo) << "\n"
                                       << result.table;
    }
}

// A guide stands in for the base alone: lobes and base must be drawn from where BsdfParts says,
// each by its part of the density.
TEST(BsdfChi2, BaseAndLobesAreDrawnApart) {
  const std::vector<test::BsdfCase> cases = test::density_cases();
  const Vec3 eyes[] = {test::direction(30, 50), test::direction(80, 300), test::direction(140, 70)};
  const double level = test::significance(static_cast<int>(cases.size()) * 3 * 2);
  test::Chi2Options options;
  options.samples = 50'000;
  options.tolerance = 1e-6;
  int layered = 0;
  for (const test::BsdfCase& c : cases)
    for (const Vec3 wo : eyes) {
      const float base = c.bsdf->parts(c.at(wo)).base_chance;
      for (const bool of_base : {true, false}) {
        const float chance = of_base ? base : 1 - base;
        if (chance < 1e-3f) continue;
        layered += of_base && base < 1;
        ++options.seed;
        const test::Chi2 result = test::chi2_sphere(
            [&](test::Random& random) -> std::optional<Vec3> {
              const float u = random.next() * chance;
              const auto s = c.bsdf->sample(c.at(wo), of_base ? 1 - base + u : u, random.next_2d());
              return s && !s->delta ? std::optional(s->wi) : std::nullopt;
            },
            [&](Vec3 wi) {
              const BsdfEval e = c.bsdf->eval(c.at(wo), wi);
              return (of_base ? e.base_pdf_w : e.pdf_w - e.base_pdf_w) / chance;
            },
            options);
        EXPECT_GT(result.p_value, level)
            << c.name << (of_base ? ", base" : ", lobes") << " from " << test::text(wo) << "\n"
            << result.table;
      }
    }
  EXPECT_GT(layered, 20);
}

TEST(BsdfChi2, NoticesAWrongDensity) {
  // The same test on a rough metal sampled at a slightly different roughness must fail.
  const Material m = test::material_of(MaterialKind::kConductor, 0.5f);
  const test::BsdfCase c = test::make_case("conductor", m);
  const Vec3 wo = test::direction(40, 20);
  ShadingPoint other = c.point;
  other.roughness = 0.53f;
  const test::Chi2 result = test::chi2_sphere(
      [&](test::Random& random) -> std::optional<Vec3> {
        const auto s = c.bsdf->sample(c.bsdf->at(other, wo), 0, random.next_2d());
        return s ? std::optional(s->wi) : std::nullopt;
      },
      [&](Vec3 wi) { return c.bsdf->eval(c.at(wo), wi).pdf_w; });
  EXPECT_LT(result.p_value, 1e-6) << result.table;
}

}  // namespace
}  // namespace qray
