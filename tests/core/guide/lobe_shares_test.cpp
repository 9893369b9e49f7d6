#include "core/guide/lobe_shares.h"

#include <gtest/gtest.h>

#include "core/math/warp.h"
#include "tests/support/random.h"

namespace qray {
namespace {

constexpr LobeShares::Means kNothingUsual{};

// A surface without a base whose lobe has the density of the cosine to the power n about z. The
// guide draws the cap about z with this cosine alone, uniformly, and a twentieth of its directions
// from the whole hemisphere.
struct Place {
  float power, cos_cap;
  float lobe_pdf_w(float z) const { return (power + 1) * std::pow(z, power) * kInvPi / 2; }
  float guide_pdf_w(float z) const {
    return (0.05f + (z > cos_cap ? 0.95f / (1 - cos_cap) : 0)) * kInvPi / 2;
  }

  // What is told by samples that this share drew, where light arrives from the cap alone.
  LobeShares told(float drawn, bool smooth) const {
    LobeShares sums;
    test::Random random(5);
    for (int i = 0; i < 20000; ++i) {
      const float u = random.next();
      const bool from_guide = random.next() < drawn, from_cap = random.next() < 0.95f;
      const float z = !from_guide ? std::pow(u, 1 / (power + 1))
                      : from_cap  ? lerp(u, cos_cap, 1.0f)
                                  : u;
      GuideVertex v;
      v.arriving = z > cos_cap ? Rgb{1.0f} : Rgb{};
      v.bsdf.pdf_w = v.bsdf.f_cos = lobe_pdf_w(z);
      v.bsdf.guide_pdf_w = guide_pdf_w(z);
      v.bsdf.surface = {0, smooth};
      v.pdf_w = GuideMixture::in_place_of_base(0, drawn).pdf_w(v.bsdf.guide_pdf_w, 0, v.bsdf.pdf_w);
      sums += LobeShares::of(v, 0.5f, 0);
    }
    return sums;
  }
};

TEST(LobeShares, ANarrowLobeDrawsItsOwnDirections) {
  const Place place{200, 0.2f};
  for (const float drawn : {0.0f, 0.5f})
    EXPECT_EQ(place.told(drawn, false).best(kNothingUsual), 0.1f);
}

TEST(LobeShares, ABroadLobeIsAimedAtWhereLightComesFrom) {
  const Place place{1, 0.99f};
  for (const float drawn : {0.2f, 0.8f})
    EXPECT_EQ(place.told(drawn, false).best(kNothingUsual), 0.8f) << drawn;
}

// Whatever share drew the samples, they tell the same of each.
TEST(LobeShares, WhatIsToldDoesNotDependOnWhatDrew) {
  const Place place{4, 0.9f};
  const LobeShares a = place.told(0.2f, false), b = place.told(0.8f, false);
  for (size_t i = 0; i < a.moments.size(); ++i) {
    const auto told = static_cast<double>(a.moments[i]);
    EXPECT_NEAR(static_cast<double>(b.moments[i]) / told, 1, 0.06) << i;
  }
}

TEST(LobeShares, SurfacesWithoutRoughLobesTellNothing) {
  for (const int64_t moment : Place{1, 0.99f}.told(0.5f, true).moments) EXPECT_EQ(moment, 0);
  GuideVertex diffuse;
  diffuse.arriving = Rgb{1.0f};
  diffuse.pdf_w = diffuse.bsdf.pdf_w = diffuse.bsdf.base_pdf_w = diffuse.bsdf.f_cos = 1;
  for (const int64_t moment : LobeShares::of(diffuse, 1, 0).moments) EXPECT_EQ(moment, 0);
}

TEST(LobeShares, FewSamplesAreCompletedByWhatIsUsual) {
  LobeShares few;
  EXPECT_EQ(few.best(kNothingUsual), LobeShares::kUnknown);
  const LobeShares::Means usual{4, 2, 1, 3};
  EXPECT_EQ(few.best(usual), 0.5f);
  few.moments = {1000, 1000, 2000, 1000};  // of two or three samples
  EXPECT_EQ(few.best(usual), 0.25f);
}

TEST(LobeShares, NoNumbersAreLeftOut) {
  GuideVertex v;
  v.bsdf.surface.base_chance = 0;
  v.arriving = Rgb{std::numeric_limits<float>::quiet_NaN()};
  v.pdf_w = v.bsdf.f_cos = 1;
  for (const int64_t moment : LobeShares::of(v, 1, 0).moments) EXPECT_EQ(moment, 0);
  v.arriving = Rgb{1.0f};
  v.pdf_w = 1;
  v.bsdf = {.pdf_w = 0, .f_cos = 1, .surface = {.base_chance = 0}};  // none would draw it
  for (const int64_t moment : LobeShares::of(v, 1, 0).moments) EXPECT_GT(moment, 0);
}

}  // namespace
}  // namespace qray
