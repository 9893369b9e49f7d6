#include "core/recover/recover.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/image/metrics.h"
#include "core/recover/included_networks.h"
#include "core/recover/joint_bilateral.h"
#include "core/recover/ladder.h"
#include "tests/support/random.h"

namespace qray {
namespace {

constexpr int kRecoverSide = 64;  // pixels

// A floor and a wall of two albedos under an even light, and noise.
TrainingView corner(float noise, uint64_t seed) {
  test::Random random(seed);
  TrainingView view{Image(kRecoverSide, kRecoverSide, kFeatures),
                    Image(kRecoverSide, kRecoverSide, 3), Image(kRecoverSide, kRecoverSide, 1),
                    Image(kRecoverSide, kRecoverSide, 3)};
  for (int y = 0; y < kRecoverSide; ++y)
    for (int x = 0; x < kRecoverSide; ++x) {
      const bool wall = 3 * y + x < 2 * kRecoverSide;
      const float albedo = (x / 6 + y / 6) % 2 ? 0.7f : 0.3f, light = wall ? 2.0f : 0.5f;
      for (int k = 0; k < 3; ++k) view.features.at(x, y, k) = albedo;
      view.features.at(x, y, kFeatureNormal + (wall ? 0 : 1)) = 1;
      view.features.at(x, y, kFeatureDepth) = 1;
      view.noise.at(x, y, 0) = noise / (1 + noise);
      for (int c = 0; c < 3; ++c) {
        view.target.at(x, y, c) = albedo * light;
        view.input.at(x, y, c) = albedo * light * (1 + noise * (2 * random.next() - 1));
      }
    }
  return view;
}

// No pixel's own noise is known: what the network makes counts alone.
RecoveryInput input_of(const TrainingView& view) {
  Image unknown(kRecoverSide, kRecoverSide, 1);
  for (float& e : unknown.data()) e = std::numeric_limits<float>::infinity();
  return {view.features, view.input, view.noise, std::move(unknown)};
}

TEST(Recover, APictureThatItsFeaturesExplainComesBackWhole) {
  const TrainingView view = corner(0, 1);
  TaskPool pool(2);
  const Image bilinear = recover_quarter(no_network(), input_of(view), pool);
  const Image untrained = recover_quarter(untrained_network(16, 1), input_of(view), pool);
  EXPECT_LT(relmse(untrained, view.target), 0.1 * relmse(bilinear, view.target));
  const JointBilateral filter;
  EXPECT_LT(relmse(joint_bilateral(filter, view.features, view.input, pool), view.target),
            0.1 * relmse(bilinear, view.target));
}

TEST(Recover, OnlyTheFirstPixelOfEachBlockIsRead) {
  TrainingView view = corner(0.5f, 2);
  TaskPool pool(2);
  const Network nets[] = {no_network(), untrained_network(16, 1)};
  std::vector<Image> before;
  for (const Network& net : nets) before.push_back(recover_quarter(net, input_of(view), pool));
  for (int y = 0; y < kRecoverSide; ++y)
    for (int x = 0; x < kRecoverSide; ++x)
      if (x % 2 || y % 2) view.input.set_rgb(x, y, Rgb{1e6f});
  for (size_t i = 0; i < before.size(); ++i)
    EXPECT_EQ(relmse(recover_quarter(nets[i], input_of(view), pool), before[i]), 0);
}

TEST(Recover, AllPixelsMakeABetterPictureThanAQuarter) {
  const TrainingView view = corner(0.9f, 3);
  TaskPool pool(2);
  const Network net = untrained_network(16, 1);
  const double quarter = relmse(recover_quarter(net, input_of(view), pool), view.target);
  const double all = relmse(recover_all(net, input_of(view), pool), view.target);
  EXPECT_LT(all, 0.6 * quarter);
  EXPECT_LT(all, 0.2 * relmse(view.input, view.target));
}

TEST(Recover, AFittedFilterIsBetterThanThatItBeganWith) {
  const std::vector<TrainingView> views{corner(0.9f, 4), corner(0.9f, 5)};
  TaskPool pool(2);
  const auto error = [&](const JointBilateral& filter) {
    const TrainingView unseen = corner(0.9f, 6);
    return relmse(joint_bilateral(filter, unseen.features, unseen.input, pool), unseen.target);
  };
  EXPECT_LT(error(fitted_joint_bilateral(views, pool)), 0.8 * error({}));
}

Rung rung(const std::string& name, std::vector<double> held_out) {
  Rung r;
  r.name = name;
  r.held_out = std::move(held_out);
  return r;
}

TEST(Ladder, TheCheapestThatIsAsGoodIsTaken) {
  const std::vector<Rung> rungs{rung("a", {2, 4, 3, 2}), rung("b", {1.02, 2.04, 1.5, 1.0}),
                                rung("c", {1, 2, 1.5, 1})};
  EXPECT_EQ(cheapest_good(rungs, 1), 1u);
}

TEST(Ladder, OneThatIsBetterByLuckAloneDoesNotCount) {
  // The mean of "a" is within 5 % of that of "b", but by one view.
  const std::vector<Rung> rungs{rung("a", {1.3, 1.3, 1.3, 1.3, 0.1}), rung("b", {1, 1, 1, 1, 1.2})};
  EXPECT_EQ(cheapest_good(rungs, 1), 1u);
}

}  // namespace
}  // namespace qray
