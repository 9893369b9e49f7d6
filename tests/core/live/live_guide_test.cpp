#include "core/live/live_guide.h"

#include <gtest/gtest.h>

#include "core/job/run_job.h"
#include "tests/support/render.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

constexpr float kUnguided = 3;  // how far samples lie from each other without a guide: much noise

// What the pixels of a small picture tell of a pass whose samples lie `distance` from each other.
void measure(NoiseEstimate& noise, bool guided, float distance) {
  const double saved = sqr(kUnguided) - sqr(distance);  // of both samples
  noise.start_pass(guided, /*learning=*/guided);
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x) {
      const float low = 1 - distance / 2, high = 1 + distance / 2;
      noise.add(x, y, 0, 2, {low, high, low, high}, saved);
    }
  ASSERT_TRUE(noise.end_pass());
}

// Has learned enough to be asked.
std::unique_ptr<Guide> learned_guide(const PreparedScene& scene) {
  RenderSettings settings = test::small_settings("adaptive", 64, 64);
  settings.gate = false;
  const test::Rendered rendered = test::render(scene, settings);
  std::unique_ptr<Guide> guide = load_guide(scene, settings, rendered.job.table).value();
  EXPECT_TRUE(GuideGate::knows_enough(guide->stats().samples_seen));
  return guide;
}

// Passes of a camera at rest, half of each kind, until the gate has judged the guided ones twice.
void rest(LiveGuide& guide, float guided_distance) {
  GuideDecision decision(*guide.active(), /*open=*/false,
                         /*view_lasts=*/false);
  NoiseEstimate noise(4, 4);
  PassCost cost, guided_cost;
  for (uint64_t samples = 0; samples < 8; ++samples) {
    decision.start_pass(samples, 1000, /*may_learn=*/true);
    measure(noise, decision.guided(), decision.guided() ? guided_distance : kUnguided);
    cost = {cost.paths + 100, cost.rays + 500, cost.lookups + (decision.guided() ? 300 : 0)};
    if (decision.guided())
      guided_cost = {guided_cost.paths + 100, guided_cost.rays + 500, cost.lookups};
    decision.judge(samples + 1, cost, guided_cost, &noise);
    guide.judged(decision);
  }
}

TEST(LiveGuide, OneThatDoesNotPayWhereTheCameraRestsIsLeftUntilItDoes) {
  const auto scene = test::prepare(test::room());
  LiveGuide guide(learned_guide(*scene), /*gate=*/true);
  EXPECT_TRUE(guide.guides());
  rest(guide, 12.0f);
  EXPECT_FALSE(guide.guides());
  EXPECT_FALSE(guide.learns(/*whatever_time=*/true));
  rest(guide, 0.3f);
  EXPECT_TRUE(guide.guides());
  rest(guide, 12.0f);
  EXPECT_FALSE(guide.guides());
  guide.scene_changed({});
  EXPECT_TRUE(guide.learns(/*whatever_time=*/true)) << "other light, another judgement";
}

TEST(LiveGuide, OneThatKnowsMuchLearnsFromFew) {
  const auto scene = test::prepare(test::room());
  std::unique_ptr<Guide> taught = learned_guide(*scene);
  const std::unique_ptr<Guide> same = learned_guide(*scene);
  constexpr uint64_t kPaths = 20'000;  // of a frame
  EXPECT_FALSE(LiveGuide(learned_guide(*scene), true).learns_from_few(kPaths));
  while (taught->stats().samples_seen < 64 * kPaths) ASSERT_TRUE(taught->merge(*same).ok());
  const LiveGuide guide(std::move(taught), /*gate=*/true);
  EXPECT_TRUE(guide.learns_from_few(kPaths));
  EXPECT_FALSE(guide.learns_from_few(1000)) << "too few to tell what a view is like";
}

TEST(LiveGuide, LearnsWhereThereIsTime) {
  const auto scene = test::prepare(test::room());
  LiveGuide guide(learned_guide(*scene), /*gate=*/true);
  EXPECT_TRUE(guide.learns(/*whatever_time=*/false));
  guide.frame_took(0.02, 0.08);
  EXPECT_FALSE(guide.learns(/*whatever_time=*/false));
  EXPECT_TRUE(guide.learns(/*whatever_time=*/true));
  guide.frame_took(0, 0.5);
  EXPECT_TRUE(guide.learns(/*whatever_time=*/false));
  guide.switch_to(false);
  EXPECT_FALSE(guide.learns(/*whatever_time=*/true));
  EXPECT_EQ(guide.active(), nullptr);
}

}  // namespace
}  // namespace qray
