#include "core/render/guide_gate.h"

#include <gtest/gtest.h>

namespace qray {
namespace {

constexpr uint64_t kSeen = 1'000'000;
const PassCost kUnguided{100, 600, 0}, kGuided{100, 500, 100};

// Gains of passes that end at 4, 8, 16, 32 ... samples.
GuideGate after(std::initializer_list<double> gains, double lookup_rays = 1) {
  GuideGate gate(lookup_rays);
  gate.unguided_pass(kUnguided);
  uint64_t samples = 2;
  for (double gain : gains) gate.guided_pass(samples *= 2, kGuided, 1 / gain, 1);
  return gate;
}

TEST(GuideGate, TheFirstSamplesAreUnguided) {
  const GuideGate gate(1);
  EXPECT_FALSE(gate.guides(0, kSeen));
  EXPECT_FALSE(gate.guides(1, kSeen));
  EXPECT_TRUE(gate.guides(2, kSeen));
  EXPECT_FALSE(gate.guides(2, 1000)) << "a table that saw next to nothing";
}

TEST(GuideGate, TheGainIsVarianceTimesCost) {
  GuideGate gate(1.5);
  gate.unguided_pass(kUnguided);
  EXPECT_DOUBLE_EQ(gate.guided_pass(4, kGuided, 0.5, 2), 2 * 6 / (0.5 * (5 + 1.5)));
  EXPECT_EQ(gate.guided_pass(8, kGuided, 0, 2), 0) << "not known";
}

TEST(GuideGate, AGuideThatLosesIsLeft) {
  const GuideGate gate = after({0.7, 0.7, 0.7});
  EXPECT_FALSE(gate.on());
  EXPECT_FALSE(gate.learns());
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

TEST(GuideGate, ALoserThatGetsBetterGoesOn) {
  EXPECT_TRUE(after({0.4, 0.5, 0.7, 0.9}).on());
  EXPECT_FALSE(after({0.4, 0.5, 0.7, 0.71}).on());
}

TEST(GuideGate, LearningEndsWhenItBringsNothingMore) {
  EXPECT_TRUE(after({2, 2, 2}).learns()) << "too early to say";
  EXPECT_TRUE(after({1, 2, 3, 4, 5}).learns());
  const GuideGate flat = after({1, 2, 3, 3});
  EXPECT_FALSE(flat.learns());
  EXPECT_TRUE(flat.on()) << "it goes on guiding";
}

TEST(GuideGate, GrowthEndsWhenItBringsLittleTwice) {
  EXPECT_FALSE(after({1, 1.2, 1.4}).grows());
  EXPECT_TRUE(after({1, 1.2, 1.6}).grows()) << "once is noise";
  EXPECT_TRUE(after({1, 1.2, 1.6, 1.7}).grows());
  EXPECT_TRUE(after({1, 1.2, 1.4}).learns());
}

TEST(GuideGate, AnOpenGateDecidesNothing) {
  GuideGate gate(1, false, /*open=*/true);
  EXPECT_TRUE(gate.guides(0, 0));
  gate.unguided_pass(kUnguided);
  for (const uint64_t samples : {4, 8, 16, 32, 64})
    EXPECT_GT(gate.guided_pass(samples, kGuided, 10, 1), 0);
  EXPECT_TRUE(gate.on() && gate.learns() && gate.grows());
}

}  // namespace
}  // namespace qray
