#include "core/render/pilot.h"

#include <gtest/gtest.h>

#include "core/job/run_job.h"
#include "tests/support/render.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

struct Tried {
  std::optional<Pilot> pilot;
  GuideStats table;
};

Tried try_pilot(const PreparedScene& scene, const RenderSettings& settings, int threads = 2,
                const GuideWorth& worth = {}) {
  const std::unique_ptr<Guide> guide = load_guide(scene, settings, std::nullopt).value();
  if (guide) guide->set_worth(worth);
  TaskPool pool(threads);
  const SteadyClock clock;
  const std::optional<Pilot> pilot = render_pilot(scene, settings, guide.get(), pool, clock, {});
  return {pilot, guide ? guide->stats() : GuideStats{}};
}

TEST(Pilot, TellsWhatUnguidedPathsCostAndTeachesTheGuide) {
  const auto scene = test::prepare(test::room());
  const Tried tried = try_pilot(*scene, test::small_settings("adaptive", 128, 1));
  ASSERT_TRUE(tried.pilot);
  GuideGate gate = tried.pilot->gate;
  gate.guided(1, 0, {1, 1, 0}, 1, 1);
  EXPECT_GT(gate.unguided_cost(), 1);
  EXPECT_GT(tried.table.samples_seen, 0u);
  const PathCounters& cost = tried.pilot->counters;
  EXPECT_EQ(cost.paths % 4096, 0u) << "a quarter of the pixels, whole samples";
  EXPECT_GE(cost.paths, 2u * 4096);
  EXPECT_LE(cost.paths, 16u * 4096);
}

TEST(Pilot, OfAQuietPictureIsShort) {
  const RenderSettings settings = test::small_settings("adaptive", 256, 1);
  const Tried quiet = try_pilot(*test::included_scene("cornell-box"), settings),
              noisy = try_pilot(*test::included_scene("lamp-room"), settings);
  ASSERT_TRUE(quiet.pilot && noisy.pilot);
  EXPECT_TRUE(quiet.pilot->gate.on_part());
  EXPECT_EQ(quiet.pilot->counters.paths, 2u * 4096);
  EXPECT_FALSE(noisy.pilot->gate.on_part());
  EXPECT_GT(noisy.pilot->counters.paths, 2u * 4096);
}

// So few pixels that a pilot of a sixteenth of them would not see its noise.
TEST(Pilot, OfASmallNoisyPictureSeesItsNoise) {
  const auto scene = test::included_scene("lamp-room");
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    const Tried tried = try_pilot(*scene, test::small_settings("adaptive", 128, 1, seed));
    ASSERT_TRUE(tried.pilot);
    EXPECT_FALSE(tried.pilot->gate.on_part()) << "seed " << seed;
  }
}

TEST(Pilot, TheThreadsDoNotMatter) {
  const auto scene = test::prepare(test::room());
  const RenderSettings settings = test::small_settings("adaptive", 128, 1);
  const Tried one = try_pilot(*scene, settings, 1), three = try_pilot(*scene, settings, 3);
  EXPECT_EQ(one.pilot->counters.rays, three.pilot->counters.rays);
  EXPECT_EQ(one.pilot->gate.on_part(), three.pilot->gate.on_part());
  EXPECT_EQ(one.table.samples_seen, three.table.samples_seen);
}

TEST(Pilot, ThereIsNoneWhereThereIsNothingToFindOut) {
  const auto scene = test::prepare(test::room());
  const RenderSettings settings = test::small_settings("adaptive", 128, 1);
  for (const char* method : {"none", "ppg"})
    EXPECT_FALSE(try_pilot(*scene, test::small_settings(method, 128, 1)).pilot) << method;
  EXPECT_FALSE(try_pilot(*scene, test::small_settings("adaptive", 100, 1)).pilot) << "small";
  EXPECT_FALSE(try_pilot(*scene, settings, 2, {3, 6}).pilot) << "its table paid";
  EXPECT_TRUE(try_pilot(*scene, settings, 2, {1.1, 6}).pilot);
  RenderSettings open = settings, fixed = settings, quarter = settings, no_nee = settings;
  open.gate = false;
  fixed.learning_samples = 0;
  quarter.pixels = Pixels::kQuarter;
  EXPECT_FALSE(try_pilot(*scene, open).pilot);
  EXPECT_FALSE(try_pilot(*scene, fixed).pilot);
  EXPECT_FALSE(try_pilot(*scene, quarter).pilot) << "a quarter of too few pixels";
  no_nee.nee = false;
  EXPECT_TRUE(try_pilot(*scene, no_nee).pilot);
}

TEST(Pilot, ItsPathsCountInItsJob) {
  const auto scene = test::prepare(test::room());
  const RenderSettings settings = test::small_settings("adaptive", 128, 2);
  const RenderStats stats = test::render(*scene, settings).job.stats;
  const PathCounters pilot = try_pilot(*scene, settings).pilot->counters;
  EXPECT_EQ(stats.paths, 2u * 128 * 128 + pilot.paths);
  EXPECT_EQ(stats.samples_per_pixel, 2u);
}

TEST(Pilot, AJobStopsInIt) {
  const auto scene = test::prepare(test::room());
  const RenderSettings settings = test::small_settings("adaptive", 128, 1);
  const std::unique_ptr<Guide> guide = load_guide(*scene, settings, std::nullopt).value();
  TaskPool pool(2);
  const SteadyClock clock;
  std::stop_source stop;
  stop.request_stop();
  EXPECT_FALSE(render_pilot(*scene, settings, guide.get(), pool, clock, stop.get_token()));
}

}  // namespace
}  // namespace qray
