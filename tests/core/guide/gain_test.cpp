#include "core/guide/gain.h"

#include <gtest/gtest.h>

#include <array>

#include "core/guide/adaptive.h"
#include "core/guide/dahm_keller.h"
#include "core/guide/huang.h"
#include "core/guide/ppg.h"
#include "core/math/warp.h"
#include "tests/core/guide/one_point.h"
#include "tests/support/random.h"

namespace qray {
namespace {

using test::kNormal, test::kPoint, test::unit_cube;

// Passes of events at one point; `local` draws a direction in the point's frame and sets its
// density, `light` says what arrives from it.
template <class Local, class Light>
GuidePoint teach(Guide& guide, int passes, int events, Local local, Light light) {
  test::Random random(3);
  for (int pass = 0; pass < passes; ++pass) {
    const std::unique_ptr<GuideDelta> delta = guide.make_delta();
    for (int i = 0; i < events; ++i) {
      GuideVertex v;
      v.at = guide.find(kPoint, kNormal);
      v.p = kPoint;
      v.guidable = true;
      const Vec3 w = local(random, v.pdf_w);
      v.wi = v.at.frame.to_world(w);
      v.transition.emitted = light(w);
      v.arriving = Rgb{v.transition.emitted};
      guide.record({&v, 1}, *delta);
    }
    guide.update(*delta);
    guide.end_pass();
  }
  return guide.find(kPoint, kNormal);
}

Vec3 even_hemisphere(test::Random& random, float& pdf_w) {
  pdf_w = kUniformHemispherePdfW;
  return square_to_uniform_hemisphere(random.next_2d());
}
Vec3 even_sphere(test::Random& random, float& pdf_w) {
  pdf_w = kUniformSpherePdfW;
  return square_to_uniform_sphere(random.next_2d());
}

TEST(Gain, IsOneWhereCellsAreAlikeAndTheirNumberWhereOneOwnsAll) {
  const std::array<float, 4> shares{0.25f, 0.25f, 0.25f, 0.25f}, even{1, 1, 1, 1};
  EXPECT_FLOAT_EQ(gain_of_cells(shares, even, even), 1);
  const std::array<float, 4> one{0, 3, 0, 0}, to_it{1e-6f, 4, 1e-6f, 1e-6f};
  EXPECT_FLOAT_EQ(gain_of_cells(shares, one, to_it), 4);
  EXPECT_FLOAT_EQ(gain_of_cells(shares, one, even), 1) << "drawn evenly nothing is gained";
  EXPECT_FLOAT_EQ(gain_of_cells(shares, std::array<float, 4>{}, even), 1);
}

TEST(Gain, OfADensityInProportionIsTheRatioOfMoments) {
  const std::array<float, 3> shares{0.5f, 0.3f, 0.2f}, means{1, 2, 6};
  const float mean = 0.5f + 0.6f + 1.2f, square = 0.5f + 1.2f + 7.2f;
  const std::array<float, 3> weights{1 / mean, 2 / mean, 6 / mean};
  EXPECT_FLOAT_EQ(gain_of_cells(shares, means, weights), square / (mean * mean));
}

TEST(Gain, IsOneWhereNothingIsKnown) {
  for (const char* method : {"huang-published", "huang", "dahm-keller", "ppg", "adaptive"}) {
    const auto guide = make_guide(method, unit_cube());
    ASSERT_TRUE(guide.ok());
    EXPECT_EQ(guide.value()->gain(guide.value()->find(kPoint, kNormal)), 1) << method;
  }
}

TEST(Gain, OfHuangIsItsBoostOfTheOneBrightCell) {
  HuangGuide guide(HuangGuide::Density::kExact, unit_cube().bounds, {});
  const uint64_t key = guide.find(kPoint, kNormal).key;
  HuangGuide::Values values;
  values.fill(1);
  guide.set_values(key, values);
  guide.end_pass();
  EXPECT_FLOAT_EQ(guide.gain(guide.find(kPoint, kNormal)), 1);
  values.fill(0);
  const size_t up = static_cast<size_t>(nearest_direction26(kNormal));
  values[up] = 1;
  guide.set_values(key, values);
  guide.end_pass();
  const HuangGuide::Values w =
      HuangGuide::density_weights(values, hemisphere_shares26(guide.find(kPoint, kNormal).frame.z));
  EXPECT_GT(w[up], 4);
  EXPECT_FLOAT_EQ(guide.gain(guide.find(kPoint, kNormal)), w[up]);
}

TEST(Gain, OfDahmKellerIsItsDensityInTheOneBrightCell) {
  DahmKellerGuide guide(unit_cube());
  const auto alike = teach(guide, 1, 20000, even_hemisphere, [](Vec3) { return 1.0f; });
  EXPECT_NEAR(guide.gain(alike), 1, 1e-4);
  DahmKellerGuide other(unit_cube());
  // The cell of the square's middle, by its side of the horizon: u in [4/8, 5/8)^2.
  const auto bright = [](Vec3 w) {
    const float scale = 1 / std::sqrt(1 + w.z);
    const Vec2 u = disk_to_square({w.x * scale, w.y * scale});
    return u.x >= 0.5f && u.x < 0.625f && u.y >= 0.5f && u.y < 0.625f ? 1.0f : 0.0f;
  };
  const auto one = teach(other, 1, 40000, even_hemisphere, bright);
  // A quarter of the mean is added to every cell: (1 + 1/256) 64 / 1.25.
  EXPECT_NEAR(other.gain(one), 51.4, 0.1);
}

TEST(Gain, OfTreesIsFourWhereAQuarterOfTheSquareOwnsAll) {
  AdaptiveGuide adaptive(unit_cube());
  const auto quarter = [](Vec3 w) {
    const Vec2 u = disk_to_square({w.x, w.y});
    return u.x < 0.5f && u.y < 0.5f ? 1.0f : 0.0f;
  };
  // Few enough that the place is not cut.
  EXPECT_NEAR(adaptive.gain(teach(adaptive, 2, 1900, even_hemisphere, quarter)), 4, 0.6);

  PpgGuide ppg(unit_cube());
  const auto back = [](Vec3 w) { return w.z < 0 && w.y > 0 ? 1.0f : 0.0f; };
  // Four iterations: samples are splatted over a cell's width, so its edges are blurred at first.
  EXPECT_NEAR(ppg.gain(teach(ppg, 15, 2000, even_sphere, back)), 4, 0.6);
}

}  // namespace
}  // namespace qray
