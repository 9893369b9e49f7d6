#include "core/render/renderer.h"

#include <gtest/gtest.h>

#include "core/job/run_job.h"
#include "core/render/render_loop.h"
#include "tests/support/render.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

RenderSettings passes_of_one(const std::string& method, int samples) {
  RenderSettings settings = test::small_settings(method, 100, samples);
  settings.passes.assign(static_cast<size_t>(samples), 1);
  return settings;
}

Image rendered(const PreparedScene& scene, const RenderSettings& settings, size_t most_units,
               RenderMode mode, uint64_t* units_heard = nullptr) {
  const std::unique_ptr<Guide> guide = load_guide(scene, settings, std::nullopt).value();
  Film film(settings.width, settings.height);
  TaskPool pool(2);
  const SteadyClock clock;
  std::mutex mutex;
  if (units_heard)
    mode.on_samples = [&](const TileSamples&) {
      std::lock_guard lock(mutex);
      ++*units_heard;
    };
  Renderer renderer(scene, settings, guide.get(), film, pool, clock, mode);
  RenderObserver nobody;
  while (renderer.start_pass()) {
    while (renderer.units_left() > 0)
      renderer.sample(
          most_units, [] { return false; }, {}, nobody);
    renderer.end_pass();
  }
  return film.develop();
}

TEST(Renderer, HoweverItIsSteppedThePictureIsAJobs) {
  const auto scene = test::prepare(test::room());
  for (const char* method : {"none", "adaptive"}) {
    const RenderSettings settings = passes_of_one(method, 6);
    const Image job = test::render(*scene, settings).image;
    for (const size_t most : {1, 3, 1000})
      EXPECT_TRUE(test::same_bits(job, rendered(*scene, settings, most, {}))) << method << most;
  }
}

TEST(Renderer, RoundsOfAPassTakeEachPixelOnce) {
  const auto scene = test::prepare(test::room());
  const RenderSettings settings = passes_of_one("none", 3);
  uint64_t units = 0;
  RenderMode mode;
  mode.in_rounds = true;
  const Image in_rounds = rendered(*scene, settings, 5, mode, &units);
  EXPECT_TRUE(test::same_bits(test::render(*scene, settings).image, in_rounds));
  EXPECT_EQ(units, 3u * 4 * 4) << "3 passes of 4 rounds of 4 tiles";
}

// Of `none`, a pixel's samples are the same ones, in other passes.
TEST(Renderer, ARegionThatComesFirstChangesTheOrderAlone) {
  const auto scene = test::prepare(test::room());
  RenderSettings settings = test::small_settings("none", 100, 24);
  const Image even = test::render(*scene, settings).image;
  settings.region = {30, 50, 20, 20};
  const Image first = test::render(*scene, settings).image;
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 100; ++x)
      EXPECT_NEAR(luminance(first.rgb(x, y)), luminance(even.rgb(x, y)),
                  1e-5f * (1 + luminance(even.rgb(x, y))))
          << x << " " << y;
}

TEST(Renderer, MayBeKeptFromLearning) {
  const auto scene = test::prepare(test::room());
  const RenderSettings settings = passes_of_one("adaptive", 4);
  const std::unique_ptr<Guide> guide = load_guide(*scene, settings, std::nullopt).value();
  Film film(settings.width, settings.height);
  TaskPool pool(2);
  const SteadyClock clock;
  Renderer renderer(*scene, settings, guide.get(), film, pool, clock);
  RenderObserver nobody;
  while (renderer.start_pass(/*may_learn=*/false)) {
    renderer.sample(
        renderer.units(), [] { return false; }, {}, nobody);
    renderer.end_pass();
  }
  EXPECT_EQ(renderer.stats().learning_samples_per_pixel, 0u);
  EXPECT_EQ(guide->stats().samples_seen, 0u);
}

TEST(GuideDecision, TheFirstPassesAreLearnedFromAndNotGuided) {
  const auto scene = test::prepare(test::room());
  const RenderSettings settings = passes_of_one("adaptive", 4);
  const std::unique_ptr<Guide> guide = load_guide(*scene, settings, std::nullopt).value();
  GuideDecision decision(*guide, /*open=*/false, /*view_lasts=*/false);
  decision.start_pass(0, 10'000, /*may_learn=*/true);
  EXPECT_TRUE(decision.learning());
  EXPECT_FALSE(decision.guided()) << "the first samples tell what unguided ones cost";
  EXPECT_FALSE(decision.noise_changed());
  decision.judge(1, {100, 500, 0}, {}, nullptr);
  ASSERT_EQ(decision.passes().size(), 1u);
  EXPECT_TRUE(decision.passes()[0].learned);
}

TEST(GuideDecision, AGuideThatKnowsMuchLearnsFromFewPixels) {
  const auto scene = test::prepare(test::room());
  const RenderSettings settings = test::small_settings("adaptive", 128, 32);
  const TableFile table = *test::render(*scene, settings).job.table;
  const std::unique_ptr<Guide> guide = load_guide(*scene, settings, table).value();
  const std::unique_ptr<Guide> same = load_guide(*scene, settings, table).value();
  while (guide->stats().samples_seen < 16 * 4 * 16384) ASSERT_TRUE(guide->merge(*same).ok());
  const auto pixels_learned = [&](uint64_t paths) {
    GuideDecision decision(*guide, /*open=*/true, /*view_lasts=*/false);
    decision.start_pass(0, paths, /*may_learn=*/true);
    EXPECT_TRUE(decision.learning());
    int pixels = 0;
    for (int y = 0; y < 16; ++y)
      for (int x = 0; x < 16; ++x) pixels += decision.pixels().learns(x, y);
    return pixels;
  };
  const uint64_t seen = guide->stats().samples_seen;
  EXPECT_EQ(pixels_learned(seen), 256) << "a pass that tells as much as it knows";
  EXPECT_EQ(pixels_learned(16384), 32);
  EXPECT_EQ(pixels_learned(1000), 256) << "few paths, from which nothing could be told";
}

}  // namespace
}  // namespace qray
