#include "core/recover/recover.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "core/image/metrics.h"
#include "core/recover/guess.h"
#include "core/recover/included_networks.h"
#include "core/recover/joint_bilateral.h"
#include "core/recover/ladder.h"
#include "core/recover/pyramid.h"
#include "tests/support/random.h"

namespace qray {
namespace {

constexpr int kRecoverSide = 64;  // pixels

// A floor and a wall of two albedos under an even light, and noise.
TrainingView corner(float noise, uint64_t seed) {
  test::Random random(seed);
  TrainingView view{{Image(kRecoverSide, kRecoverSide, kFeatures),
                     Image(kRecoverSide, kRecoverSide, 3), Image(kRecoverSide, kRecoverSide, 1)},
                    Image(kRecoverSide, kRecoverSide, 3)};
  for (int y = 0; y < kRecoverSide; ++y)
    for (int x = 0; x < kRecoverSide; ++x) {
      const bool wall = 3 * y + x < 2 * kRecoverSide;
      const float albedo = (x / 6 + y / 6) % 2 ? 0.7f : 0.3f, light = wall ? 2.0f : 0.5f;
      for (int k = 0; k < 3; ++k) view.input.features.at(x, y, k) = albedo;
      view.input.features.at(x, y, kFeatureNormal + (wall ? 0 : 1)) = 1;
      view.input.features.at(x, y, kFeatureDepth) = 1;
      view.input.noise.at(x, y, 0) = noise / (1 + noise);
      for (int c = 0; c < 3; ++c) {
        view.target.at(x, y, c) = albedo * light;
        view.input.colour.at(x, y, c) = albedo * light * (1 + noise * (2 * random.next() - 1));
      }
    }
  return view;
}

// No pixel's own noise is known: what the network makes counts alone.
RecoveryInput input_of(const TrainingView& view) {
  Image unknown(kRecoverSide, kRecoverSide, 1);
  for (float& e : unknown.data()) e = std::numeric_limits<float>::infinity();
  RecoveryInput input = view.input;
  input.own_error = std::move(unknown);
  return input;
}

TEST(Recover, APictureThatItsFeaturesExplainComesBackWhole) {
  const TrainingView view = corner(0, 1);
  TaskPool pool(2);
  const Image bilinear = recover_quarter(Network{}, input_of(view), pool).picture;
  const Image untrained = recover_quarter(untrained_network(1), input_of(view), pool).picture;
  EXPECT_LT(relmse(untrained, view.target), 0.1 * relmse(bilinear, view.target));
  const JointBilateral filter;
  EXPECT_LT(
      relmse(joint_bilateral(filter, view.input.features, view.input.colour, pool), view.target),
      0.1 * relmse(bilinear, view.target));
}

// The first pixels of a view's blocks.
Image halved(const Image& image) {
  Image out(image.width() / 2, image.height() / 2, image.channels());
  for (int y = 0; y < out.height(); ++y)
    for (int x = 0; x < out.width(); ++x)
      for (int c = 0; c < out.channels(); ++c) out.at(x, y, c) = image.at(2 * x, 2 * y, c);
  return out;
}

TEST(Guess, FeaturesMakeThePixelsBetweenTheKnownOnesAndMemoryIsNone) {
  TaskPool pool(2);
  Guess guess(untrained_network(1));
  const TrainingView view = corner(0, 1), other = corner(0.9f, 2);
  const auto run = [&](const TrainingView& v) {
    const RecoveryInput known{halved(v.input.features), halved(v.input.colour),
                              halved(v.input.noise)};
    return guess.of_quarter(known, v.input.features, pool);
  };
  const Image first = run(view);
  EXPECT_LT(relmse(first, view.target), 0.01);
  run(other);
  EXPECT_EQ(relmse(run(view), first), 0);
}

TEST(Recover, OnlyTheFirstPixelOfEachBlockIsRead) {
  TrainingView view = corner(0.5f, 2);
  TaskPool pool(2);
  const Network nets[] = {Network{}, untrained_network(1)};
  std::vector<Image> before;
  for (const Network& net : nets)
    before.push_back(recover_quarter(net, input_of(view), pool).picture);
  for (int y = 0; y < kRecoverSide; ++y)
    for (int x = 0; x < kRecoverSide; ++x)
      if (x % 2 || y % 2) view.input.colour.set_rgb(x, y, Rgb{1e6f});
  for (size_t i = 0; i < before.size(); ++i)
    EXPECT_EQ(relmse(recover_quarter(nets[i], input_of(view), pool).picture, before[i]), 0);
}

TEST(Recover, AllPixelsMakeABetterPictureThanAQuarter) {
  const TrainingView view = corner(0.9f, 3);
  TaskPool pool(2);
  const Network net = included_network("default").value();
  const double quarter = relmse(recover_quarter(net, input_of(view), pool).picture, view.target);
  const double all = relmse(recover_all(net, input_of(view), pool).picture, view.target);
  EXPECT_LT(all, 0.6 * quarter);
  EXPECT_LT(all, 0.2 * relmse(view.input.colour, view.target));
}

TEST(Recover, SidesMayBeOddAndThePictureIsAsBrightAsItsSamples) {
  const TrainingView view = corner(0.9f, 3);
  TaskPool pool(2);
  RecoveryInput odd = input_of(view);
  for (Image* image : {&odd.features, &odd.colour, &odd.noise, &odd.own_error}) {
    Image part(kRecoverSide - 3, kRecoverSide - 9, image->channels());
    for (int y = 0; y < part.height(); ++y)
      for (int x = 0; x < part.width(); ++x)
        for (int c = 0; c < part.channels(); ++c) part.at(x, y, c) = image->at(x, y, c);
    *image = std::move(part);
  }
  const Image picture = recover_all(untrained_network(1), odd, pool).picture;
  EXPECT_EQ(picture.width(), kRecoverSide - 3);
  double got = 0, light = 0;
  for (size_t i = 0; i < picture.data().size(); ++i)
    got += static_cast<double>(picture.data()[i]),
        light += static_cast<double>(odd.colour.data()[i]);
  EXPECT_NEAR(got / light, 1, 0.05);
}

TEST(Recover, WithoutANetworkAllPixelsStayTheirSamples) {
  const TrainingView view = corner(0.9f, 3);
  TaskPool pool(2);
  EXPECT_EQ(relmse(recover_all({}, input_of(view), pool).picture, view.input.colour), 0);
}

// A shade of albedo .8 whose samples are noisy, and in it a piece that shines at radiance 16
// and whose albedo `lamp` is: all of one mesh, so that nothing else tells the two apart.
TrainingView shade(float lamp, Rgb tint, uint64_t seed) {
  test::Random random(seed);
  TrainingView view = corner(0, seed);
  for (int y = 0; y < kRecoverSide; ++y)
    for (int x = 0; x < kRecoverSide; ++x) {
      const bool shines = x / 16 == 1 && y / 16 == 1;
      for (int k = 0; k < kFeatures; ++k) view.input.features.at(x, y, k) = 0;
      view.input.features.at(x, y, kFeatureNormal) = 1;
      view.input.features.at(x, y, kFeatureDepth) = 1;
      view.input.features.at(x, y, kFeatureKind) = 1;
      view.input.noise.at(x, y, 0) = shines ? 0.0f : 0.5f;
      const float light = random.next() < 0.5f ? 0.45f : 0.05f;
      for (int c = 0; c < 3; ++c) {
        view.input.features.at(x, y, c) = tint[c] * (shines ? lamp : 0.8f);
        view.target.at(x, y, c) = tint[c] * (shines ? 16.0f : 0.2f);
        view.input.colour.at(x, y, c) = tint[c] * (shines ? 16.0f : 0.8f * light);
      }
    }
  return view;
}

double mean_light(const Image& image, int step = 1) {
  double sum = 0;
  int count = 0;
  for (int y = 0; y < image.height(); y += step)
    for (int x = 0; x < image.width(); x += step, ++count)
      sum += static_cast<double>(luminance(image.rgb(x, y)));
  return sum / count;
}

// Nor more than there is: dark samples may be so by chance.
void expect_no_more_than_was_seen(const Image& picture, const Image& input, const Image& target,
                                  int step) {
  for (int y = 0; y < kRecoverSide; ++y)
    for (int x = 0; x < kRecoverSide; ++x)
      for (int c = 0; c < 3; ++c) {
        float most = target.at(x, y, c);
        for (int j = std::max(0, y - 3); j < std::min(kRecoverSide, y + 4); ++j)
          for (int i = std::max(0, x - 3); i < std::min(kRecoverSide, x + 4); ++i)
            if (i % step == 0 && j % step == 0) most = std::max(most, input.at(i, j, c));
        ASSERT_LE(picture.at(x, y, c), most) << x << ", " << y;
      }
}

TEST(Recover, NoLightComesFromALampThatIsBlackOrInATintedMirror) {
  TaskPool pool(2);
  for (const Rgb tint : {Rgb{1}, Rgb{0.9f, 0.6f, 0.1f}})
    for (const float lamp : {0.0f, 1.0f})  // black, and as its feature is now
      for (const char* name : {"untrained", "default"}) {
        const TrainingView view = shade(lamp, tint, 7);
        const Network net = included_network(name).value();
        const Recovered quarter = recover_quarter(net, input_of(view), pool),
                        all = recover_all(net, input_of(view), pool);
        EXPECT_NEAR(mean_light(all.picture) / mean_light(view.input.colour), 1, 0.1)
            << name << lamp;
        EXPECT_NEAR(mean_light(quarter.picture, 2) / mean_light(view.input.colour, 2), 1, 0.1)
            << name << lamp;
        expect_no_more_than_was_seen(all.picture, view.input.colour, view.target, 1);
        expect_no_more_than_was_seen(quarter.picture, view.input.colour, view.target, 2);
      }
}

TEST(Recover, AFittedFilterIsBetterThanThatItBeganWith) {
  const std::vector<TrainingView> views{corner(0.9f, 4), corner(0.9f, 5)};
  TaskPool pool(2);
  const auto error = [&](const JointBilateral& filter) {
    const TrainingView unseen = corner(0.9f, 6);
    return relmse(joint_bilateral(filter, unseen.input.features, unseen.input.colour, pool),
                  unseen.target);
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
