// Guides that learn by themselves draw directions with the density they tell, whatever they were
// taught. (The thesis' method has tables set by hand: huang_chi2_test.cpp.)
#include <gtest/gtest.h>

#include "core/guide/guide.h"
#include "core/math/warp.h"
#include "tests/support/chi2.h"
#include "tests/support/stats.h"

namespace qray {
namespace {

const Vec3 kPoint{0.4f, 0.3f, 0.6f};

struct Lesson {
  const char* name;
  float (*arriving)(Vec3 wi, test::Random& random);  // luminance; wi local
  int events = 1500;                                 // a pass
  bool glossy = false;  // the surface draws half of them close to one direction
};
constexpr float kPower = 200;  // of the glossy lobe's cosine, about (.6, 0, .8)
const Lesson kLessons[] = {
    {"even", [](Vec3, test::Random&) { return 1.0f; }},
    {"black", [](Vec3, test::Random&) { return 0.0f; }},
    {"a spot", [](Vec3 w, test::Random&) { return w.x > 0.55f && w.y > 0.55f ? 90.0f : 0.1f; }},
    {"all from the horizon", [](Vec3 w, test::Random&) { return w.z < 0.1f ? 5.0f : 0.0f; }},
    {"fireflies", [](Vec3, test::Random& r) { return r.next() < 1e-3f ? 900.0f : 0.01f; }},
    {"one cell",
     [](Vec3 w, test::Random&) {
       return std::abs(w.x - 0.3f) < 0.01f && std::abs(w.y + 0.2f) < 0.01f ? 50.0f : 0.0f;
     }},
    {"few samples", [](Vec3 w, test::Random& r) { return w.x > 0 ? 40 * r.next() : 0.0f; }, 40},
    {"glossy", [](Vec3 w, test::Random&) { return w.x > 0.5f ? 9.0f : 1.0f; }, 1500, true},
};
// The cosine to the lobe's axis to the power, over the sphere: some of it may lie below.
float lobe_pdf_w(Vec3 w) {
  const float cosine = std::max(0.0f, dot(w, Vec3{0.6f, 0, 0.8f}));
  return (kPower + 1) * 0.5f * kInvPi * std::pow(cosine, kPower);
}
Vec3 sample_lobe(Vec2 u) {
  const float z = std::pow(u.x, 1 / (kPower + 1)), r = std::sqrt(std::max(0.0f, 1 - z * z));
  const float phi = 2 * kPi * u.y;
  return Frame(Vec3{0.6f, 0, 0.8f}).to_world({r * std::cos(phi), r * std::sin(phi), z});
}

// The square that a method's cells lie in: densities are constant in cells of 1/kBins, and bins of
// that size need no quadrature.
constexpr int kBins = 256;
struct Square {
  Vec3 (*direction)(Vec2 u);     // local
  Vec2 (*place)(Vec3 w);         // its inverse, not the code under test's
  double (*steradians)(Vec3 w);  // of a unit of the square's area
};
Vec2 concentric_inverse(double x, double y) {
  const double r = std::hypot(x, y), eighth = std::numbers::pi / 4;
  double a = r, b = r;
  if (std::abs(x) >= std::abs(y)) {
    a = std::copysign(r, x);
    b = x == 0 ? 0 : a * std::atan(y / x) / eighth;
  } else {
    b = std::copysign(r, y);
    a = b * std::atan(x / y) / eighth;
  }
  return {static_cast<float>((a + 1) / 2), static_cast<float>((b + 1) / 2)};
}
Square square_of(std::string_view method) {
  if (method == "adaptive")
    return {square_to_cosine_hemisphere, [](Vec3 w) { return concentric_inverse(w.x, w.y); },
            [](Vec3 w) { return std::numbers::pi / static_cast<double>(w.z); }};
  if (method == "dahm-keller")
    return {square_to_uniform_hemisphere,
            [](Vec3 w) {
              const double scale = 1 / std::sqrt(1 + static_cast<double>(w.z));
              return concentric_inverse(w.x * scale, w.y * scale);
            },
            [](Vec3) { return 2 * std::numbers::pi; }};
  return {[](Vec2 u) {
            const double z = 2 * static_cast<double>(u.x) - 1, r = std::sqrt(1 - z * z),
                         phi = 2 * std::numbers::pi * static_cast<double>(u.y);
            return Vec3{static_cast<float>(r * std::cos(phi)),
                        static_cast<float>(r * std::sin(phi)), static_cast<float>(z)};
          },
          [](Vec3 w) {
            const double phi = std::atan2(w.y, w.x) / (2 * std::numbers::pi);
            return Vec2{(w.z + 1) / 2, static_cast<float>(phi < 0 ? phi + 1 : phi)};
          },
          [](Vec3) { return 4 * std::numbers::pi; }};
}

test::Chi2 chi2_of(const Guide& guide, const GuidePoint& point, const Square& square,
                   Vec2 (*warp)(Vec2), uint64_t seed) {
  constexpr int kDraws = 500'000;
  // Rounding takes a few directions over the borders of the brightest cells: coarser bins have
  // fewer.
  constexpr int kCoarse = kBins / 4;
  std::vector<double> observed(kCoarse * kCoarse), expected(kCoarse * kCoarse);
  const auto bin = [](Vec2 u) {
    const auto index = [](float v) {
      return std::clamp(static_cast<int>(v * kCoarse), 0, kCoarse - 1);
    };
    return static_cast<size_t>(index(u.y) * kCoarse + index(u.x));
  };
  test::Random random(seed);
  for (int i = 0; i < kDraws; ++i) {
    const Vec3 wi = guide.sample(point, warp(random.next_2d())).wi;
    ++observed[bin(square.place(point.frame.to_local(wi)))];
  }
  double integral = 0;
  for (int y = 0; y < kBins; ++y)
    for (int x = 0; x < kBins; ++x) {
      const Vec2 u{(static_cast<float>(x) + 0.5f) / kBins, (static_cast<float>(y) + 0.5f) / kBins};
      const Vec3 local = square.direction(u);
      const double pdf_w = guide.pdf_w(point, point.frame.to_world(local));
      const double chance = pdf_w * square.steradians(local) / (kBins * kBins);
      expected[bin(u)] += chance * kDraws;
      integral += chance;
    }
  test::Chi2 result = test::chi2_counts(observed, expected);
  result.integral = integral;
  return result;
}

class GuideChi2 : public ::testing::TestWithParam<const char*> {
 protected:
  // Taught for some passes by directions drawn from what it knew so far.
  static std::unique_ptr<Guide> taught(Vec3 n, const Lesson& lesson) {
    GuideSetup setup;
    setup.bounds = {{0, 0, 0}, {1, 1, 1}};
    setup.brightest_light = 100;
    setup.adaptive.min_gain = 0;  // so that uniform tables are drawn from too
    std::unique_ptr<Guide> guide = make_guide(GetParam(), setup).value();
    test::Random random(11);
    for (int pass = 0; pass < 8; ++pass) {
      const std::unique_ptr<GuideDelta> delta = guide->make_delta();
      for (int i = 0; i < lesson.events; ++i) {
        GuideVertex v;
        v.at = guide->find(kPoint, n);
        v.p = kPoint;
        v.guidable = true;
        const bool guides = guide->mixture(v.at, {lesson.glossy ? 0.0f : 1.0f}).guide > 0;
        const bool lobe = lesson.glossy && (!guides || random.next() < 0.5f);
        if (lobe) {
          v.wi = v.at.frame.to_world(sample_lobe(random.next_2d()));
        } else if (guides) {
          v.wi = guide->sample(v.at, random.next_2d()).wi;
        } else {
          v.wi = v.at.frame.to_world(square_to_cosine_hemisphere(random.next_2d()));
        }
        const Vec3 local = v.at.frame.to_local(v.wi);
        v.bsdf.pdf_w = lesson.glossy ? lobe_pdf_w(local) : cosine_hemisphere_pdf_w(local.z);
        v.bsdf.f_cos = 0.5f * v.bsdf.pdf_w;
        v.pdf_w = guides ? guide->pdf_w(v.at, v.wi) : v.bsdf.pdf_w;
        if (lesson.glossy && guides) v.pdf_w = 0.5f * (v.pdf_w + v.bsdf.pdf_w);
        v.transition.emitted = lesson.arriving(v.at.frame.to_local(v.wi), random);
        v.arriving = Rgb{v.transition.emitted};
        guide->record({&v, 1}, *delta);
      }
      guide->update(*delta);
      guide->end_pass();
    }
    return guide;
  }
};

TEST_P(GuideChi2, SamplesFollowTheDensity) {
  const Vec3 normals[] = {
      {0, 0, 1}, {-1, 0, 0}, normalize(Vec3{1, -2, 0.3f}), normalize(Vec3{-1, 1.1f, 1.05f})};
  const double level = test::significance(static_cast<int>(std::size(kLessons) * 4 * 3));
  uint64_t seed = 1;
  int tested = 0;
  for (const Lesson& lesson : kLessons)
    for (Vec3 n : normals) {
      const std::unique_ptr<Guide> guide = taught(n, lesson);
      const GuidePoint point = guide->find(kPoint, n);
      if (guide->mixture(point, {}).guide == 0) continue;  // it would not be asked
      ++tested;
      const test::Chi2 result = chi2_of(
          *guide, point, square_of(GetParam()), [](Vec2 u) { return u; }, seed++);
      EXPECT_GT(result.p_value, level) << lesson.name << "\n" << result.table;
      EXPECT_NEAR(result.integral, 1, 1e-4) << lesson.name;
    }
  EXPECT_GE(tested, std::string_view(GetParam()) == "adaptive" ? 32 : 20);
}

TEST_P(GuideChi2, SamplesComeWithTheirDensity) {
  const Vec3 n = normalize(Vec3{1, -2, 0.3f});
  const std::unique_ptr<Guide> guide = taught(n, kLessons[2]);
  const GuidePoint point = guide->find(kPoint, n);
  test::Random random(3);
  int apart = 0;  // by rounding, at the borders of cells
  for (int i = 0; i < 100000; ++i) {
    const GuideSample s = guide->sample(point, random.next_2d());
    apart += std::abs(guide->pdf_w(point, s.wi) / s.pdf_w - 1) > 1e-3f;
  }
  EXPECT_LT(apart, 100);
}

TEST_P(GuideChi2, ASamplerALittleWrongFails) {
  const std::unique_ptr<Guide> guide = taught({0, 0, 1}, kLessons[2]);
  const GuidePoint point = guide->find(kPoint, {0, 0, 1});
  const auto warp = [](Vec2 u) { return Vec2{u.x * (0.9f + 0.1f * u.x), u.y}; };
  EXPECT_LT(chi2_of(*guide, point, square_of(GetParam()), warp, 1).p_value, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Methods, GuideChi2, ::testing::Values("dahm-keller", "ppg", "adaptive"),
                         [](const auto& info) {
                           std::string name = info.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

// What `adaptive` expects is the mean over the projected hemisphere of what arrived.
class AdaptiveExpectation : public GuideChi2 {};

TEST_P(AdaptiveExpectation, IsWhatArrived) {
  const std::unique_ptr<Guide> even_guide = taught({0, 0, 1}, kLessons[0]);
  const GuideExpectation even = even_guide->expectation(even_guide->find(kPoint, {0, 0, 1}));
  ASSERT_TRUE(even.credible);
  // Chances of 1/256 leave the density, so what one sample says, a little uneven.
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(even.arriving[k], 1, 5e-3);
  EXPECT_LT(even.deviation, 0.2f);
  // 90 where x and y are over .55, else .1: by area of the projected disk.
  double area = 0;
  constexpr int kGrid = 2000;
  for (int i = 0; i < kGrid; ++i)
    for (int j = 0; j < kGrid; ++j) {
      const double x = 2 * (i + 0.5) / kGrid - 1, y = 2 * (j + 0.5) / kGrid - 1;
      area += x * x + y * y < 1 && x > 0.55 && y > 0.55;
    }
  const double share = area * 4 / (kGrid * kGrid) / std::numbers::pi;
  const std::unique_ptr<Guide> spot = taught({0, 0, 1}, kLessons[2]);
  EXPECT_NEAR(spot->expectation(spot->find(kPoint, {0, 0, 1})).arriving.r / (0.1 + 89.9 * share), 1,
              0.05);
}
INSTANTIATE_TEST_SUITE_P(Methods, AdaptiveExpectation, ::testing::Values("adaptive"));

}  // namespace
}  // namespace qray
