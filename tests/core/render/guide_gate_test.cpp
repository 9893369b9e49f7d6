#include "core/render/guide_gate.h"

#include <gtest/gtest.h>

namespace qray {
namespace {

constexpr uint64_t kSeen = 1'000'000, kMuchSeen = 5'000'000;   // events of a table
constexpr double kNoisy = 10, kNearlyNoisy = 2, kQuiet = 0.5;  // variance of a sample
const PassCost kUnguided{100, 600, 0}, kGuided{100, 500, 100};

// Gains of passes that end at 4, 8, 16, 32 ... samples.
GuideGate after(std::initializer_list<double> gains, uint64_t seen = kSeen) {
  GuideGate gate(1);
  gate.unguided(kUnguided, kNoisy);
  uint64_t samples = 2;
  for (double gain : gains) gate.guided(samples *= 2, seen, kGuided, 1 / gain, 1);
  return gate;
}

TEST(GuideGate, TheFirstSamplesAreUnguided) {
  const GuideGate gate(1);
  EXPECT_FALSE(gate.guides(0, kSeen));
  EXPECT_FALSE(gate.guides(1, kSeen));
  EXPECT_TRUE(gate.guides(2, kSeen));
  EXPECT_FALSE(gate.guides(2, 1000)) << "a table that saw next to nothing";
}

TEST(GuideGate, ATableThatPaidGuidesFromTheFirstSample) {
  const GuideWorth paid{3, 0.75};
  GuideGate gate(1, /*warm=*/true, false, paid);
  EXPECT_TRUE(gate.guides(0, kSeen));
  EXPECT_FALSE(gate.guides(0, 1000));
  EXPECT_DOUBLE_EQ(gate.guided(2, kSeen, kGuided, 1, 2), 2.0 * 0.75)
      << "as the table tells it: no pass was unguided";
  EXPECT_DOUBLE_EQ(gate.unguided_cost(), 0.75);
  gate.guided(4, kSeen, kGuided, 1, 1);
  EXPECT_FALSE(gate.on()) << "here it does not pay";
  EXPECT_FALSE(gate.guides(5, kSeen));
}

TEST(GuideGate, ATableThatDidNotPayOrIsNotKnownToIsTriedAgain) {
  for (const GuideWorth& worth : {GuideWorth{}, GuideWorth{1.1, 6}, GuideWorth{3, 0}}) {
    const GuideGate gate(1, /*warm=*/true, false, worth);
    EXPECT_FALSE(gate.guides(1, kSeen));
    EXPECT_TRUE(gate.guides(2, kSeen));
  }
}

TEST(GuideGate, TheGainIsVarianceTimesCost) {
  GuideGate gate(1.5);
  gate.unguided(kUnguided, kNoisy);
  EXPECT_DOUBLE_EQ(gate.guided(4, kSeen, kGuided, 0.5, 2), 2 * 6 / (0.5 * (5 + 1.5)));
  EXPECT_DOUBLE_EQ(gate.unguided_cost(), 6 / (5 + 1.5));
  EXPECT_EQ(gate.guided(8, kSeen, kGuided, 0, 2), 0) << "not known";
}

TEST(GuideGate, AGuideThatLosesIsLeft) {
  const GuideGate gate = after({0.7, 0.7, 0.7});
  EXPECT_FALSE(gate.on());
  EXPECT_FALSE(gate.learns(100));
  EXPECT_FALSE(gate.guides(100, kSeen));
}

TEST(GuideGate, OneThatGainsLessThanAQuarterIsLeft) {
  EXPECT_FALSE(after({1.2, 1.2, 1.2}).on());
  EXPECT_TRUE(after({1.3, 1.3, 1.3}).on());
}

TEST(GuideGate, AYoungTableNeedOnlyBeNearToPaying) {
  EXPECT_TRUE(after({0.4}).on());
  EXPECT_FALSE(after({0.8, 0.8}).on());
  EXPECT_TRUE(after({1, 1}).on());
}

TEST(GuideGate, InASmallPictureALoserLearnsLonger) {
  EXPECT_TRUE(after({0.5, 0.5, 0.5, 0.5}, 900'000).on());
  EXPECT_FALSE(after({0.5, 0.5, 0.5, 0.5}, 1'100'000).on());
}

TEST(GuideGate, ALoserThatGetsBetterGoesOn) {
  EXPECT_TRUE(after({0.4, 0.5, 0.7, 0.9}).on());
  EXPECT_FALSE(after({0.4, 0.5, 0.7, 0.71}).on());
}

TEST(GuideGate, ATableThatSawMuchIsOld) {
  GuideGate gate(1);
  gate.unguided(kUnguided, kNoisy);
  gate.guided(4, 5'000'000, kGuided, 1, 1.1);
  EXPECT_TRUE(gate.on()) << "it may be getting better";
  gate.guided(6, 6'000'000, kGuided, 1, 1.1);
  EXPECT_FALSE(gate.on());
}

// A job's gate behind a pilot whose samples have that variance.
GuideGate after_pilot(double variance) {
  GuideGate pilot(1);
  pilot.unguided(kUnguided, variance);
  return pilot.after_pilot();
}

TEST(GuideGate, AfterAPilotOfMuchNoiseTheFirstSamplesAreGuided) {
  GuideGate gate = after_pilot(kNoisy);
  EXPECT_TRUE(gate.guides(0, kSeen));
  EXPECT_FALSE(gate.guides(0, 1000)) << "a table that saw next to nothing";
  EXPECT_DOUBLE_EQ(gate.guided(2, kSeen, kGuided, 1, 2), 2.0 * 6 / (5 + 1)) << "by its cost";
}

// A job of fewer samples then costs what it would without a guide.
TEST(GuideGate, WhatHasLittleToGainIsTriedLateAndOnAPart) {
  const auto gate = [](const GuideWorth& worth, double variance) {
    GuideGate pilot(1, /*warm=*/true, false, worth);
    pilot.unguided(kUnguided, variance);
    return pilot.after_pilot();
  };
  const auto expect_start = [](const GuideGate& gate, uint64_t start) {
    for (uint64_t samples = 0; samples < start; ++samples)
      EXPECT_FALSE(gate.guides(samples, kSeen) || gate.learns(samples)) << samples;
    EXPECT_TRUE(gate.guides(start, kSeen) && gate.learns(start));
    EXPECT_EQ(gate.on_part(), start > 0);
    EXPECT_TRUE(gate.on());
  };
  const GuideWorth nobody_knows, near_to_paying{1, 6}, lost{0.8, 6};
  for (const GuideWorth& worth : {nobody_knows, near_to_paying}) {
    expect_start(gate(worth, kNoisy), 0);
    expect_start(gate(worth, kQuiet), GuideGate::kLateStart);
  }
  expect_start(gate(lost, kNoisy), GuideGate::kLateStart);
  expect_start(gate(lost, kQuiet), GuideGate::kLatestStart);
}

TEST(GuideGate, APilotEndsWhenItKnowsTheNoiseAndItsTableEnough) {
  GuideGate noisy(1), quiet(1);
  EXPECT_FALSE(quiet.pilot_is_over(1, kSeen)) << "its noise is not known";
  noisy.unguided(kUnguided, kNoisy);
  quiet.unguided(kUnguided, kQuiet);
  EXPECT_TRUE(quiet.pilot_is_over(2, 0));
  EXPECT_FALSE(noisy.pilot_is_over(2, 100'000));
  EXPECT_TRUE(noisy.pilot_is_over(2, kSeen));
  EXPECT_TRUE(noisy.pilot_is_over(GuideGate::kMostPilotSamples, 0));
}

TEST(GuideGate, NoiseThatShowedOnceIsBelieved) {
  GuideGate gate(1);
  gate.unguided(kUnguided, kNoisy);
  gate.unguided(kUnguided, kQuiet);
  EXPECT_FALSE(gate.pilot_is_over(4, 0));
  EXPECT_FALSE(gate.after_pilot().on_part());
}

// Two samples a pixel may miss rare light.
TEST(GuideGate, APilotThatIsNotSureOfLittleNoiseLooksAgain) {
  GuideGate gate(1);
  gate.unguided(kUnguided, kNearlyNoisy);
  EXPECT_FALSE(gate.pilot_is_over(2, kSeen));
  EXPECT_FALSE(gate.guides(3, kSeen) || gate.learns(3)) << "it would hide the noise";
  EXPECT_TRUE(gate.pilot_is_over(4, kSeen)) << "no more showed";
  gate.unguided(kUnguided, kNoisy);
  EXPECT_FALSE(gate.pilot_is_over(4, 0)) << "its table must learn now";
  EXPECT_TRUE(gate.learns(4));
  EXPECT_TRUE(gate.after_pilot().guides(0, kSeen));
}

TEST(GuideGate, WithoutAPilotThePictureTellsItsNoise) {
  GuideGate noisy(1), quiet(1);
  noisy.unguided(kUnguided, kNoisy);
  EXPECT_FALSE(noisy.on_part());
  EXPECT_TRUE(noisy.guides(2, kSeen));
  quiet.unguided(kUnguided, kQuiet);
  EXPECT_TRUE(quiet.on_part());
  EXPECT_FALSE(quiet.guides(GuideGate::kLateStart - 1, kSeen));
  EXPECT_TRUE(quiet.guides(GuideGate::kLateStart, kSeen));
}

TEST(GuideGate, NoiseThatShowsLateEndsTheTrialOnAPart) {
  GuideGate gate = after_pilot(kQuiet);
  gate.unguided(kUnguided, kQuiet);
  EXPECT_TRUE(gate.on_part());
  gate.unguided(kUnguided, kNoisy);
  EXPECT_FALSE(gate.on_part());
}

// Tried on a part, at 4, 8, 16 ... samples.
GuideGate on_part(std::initializer_list<double> gains, uint64_t seen = kSeen) {
  GuideGate gate = after_pilot(kQuiet);
  uint64_t samples = 2;
  for (double gain : gains) gate.guided(samples *= 2, seen, kGuided, 1 / gain, 1);
  return gate;
}

TEST(GuideGate, APartIsTriedLongerAndMustGainMore) {
  const GuideGate longer = on_part({0.5, 0.95, 0.95, 0.95, 1.2});
  EXPECT_TRUE(longer.on() && longer.learns(100) && longer.on_part());
  EXPECT_FALSE(on_part({0.8, 0.8}).on());
  EXPECT_FALSE(on_part({1.8, 1.8, 1.8, 1.8, 1.8, 1.8, 1.8}).on()) << "256 samples";
  EXPECT_FALSE(on_part({1.8, 1.8}, kMuchSeen).on());
  EXPECT_TRUE(on_part({3}).on_part()) << "too early to say";
  const GuideGate won = on_part({1, 1.5, 2.1});
  EXPECT_TRUE(won.on() && !won.on_part());
}

TEST(GuideGate, LearningEndsWhenItBringsNothingMore) {
  EXPECT_TRUE(after({2, 2, 2}).learns(100)) << "too early to say";
  EXPECT_TRUE(after({1, 2, 3, 4, 5}).learns(100));
  const GuideGate flat = after({1, 2, 3, 3});
  EXPECT_FALSE(flat.learns(100));
  EXPECT_TRUE(flat.on()) << "it goes on guiding";
}

TEST(GuideGate, GrowthEndsWhenItBringsLittleTwice) {
  EXPECT_FALSE(after({1.3, 1.5, 1.7}, kMuchSeen).grows());
  EXPECT_TRUE(after({1.3, 1.5, 1.7}).grows()) << "a young table";
  EXPECT_TRUE(after({1.3, 1.5, 2}, kMuchSeen).grows()) << "once is noise";
  EXPECT_TRUE(after({1.3, 1.5, 2, 2.2}, kMuchSeen).grows());
  EXPECT_TRUE(after({1.3, 1.5, 1.7}, kMuchSeen).learns(100));
}

TEST(GuideGate, AnOpenGateDecidesNothing) {
  GuideGate gate(1, false, /*open=*/true);
  EXPECT_TRUE(gate.guides(0, 0));
  gate.unguided(kUnguided, kNoisy);
  for (const uint64_t samples : {4, 8, 16, 32, 64})
    EXPECT_GT(gate.guided(samples, kSeen, kGuided, 10, 1), 0);
  EXPECT_TRUE(gate.on() && gate.learns(100) && gate.grows());
}

}  // namespace
}  // namespace qray
