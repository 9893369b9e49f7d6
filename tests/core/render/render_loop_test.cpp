#include "core/render/render_loop.h"

#include <gtest/gtest.h>

#include <atomic>

#include "core/job/run_job.h"
#include "tests/support/render.h"
#include "tests/support/sanitized.h"
#include "tests/support/test_scenes.h"
#include "tests/support/tile_clock.h"

namespace qray {
namespace {

RenderSettings small(const std::string& method, int samples) {
  RenderSettings s;
  s.method = method;
  s.width = 100;  // two tiles wide, one of them narrow
  s.height = 70;
  s.samples = samples;
  return s;
}

struct Outcome {
  Image image;
  JobResult job;
};

Outcome run(const PreparedScene& scene, const RenderSettings& settings, int threads,
            std::optional<TableFile> table = {}) {
  Film film(settings.width, settings.height);
  TaskPool pool(threads);
  RenderObserver observer;
  Result<JobResult> job =
      run_job(scene, settings, std::move(table), film, pool, observer, {}, SteadyClock());
  EXPECT_TRUE(job.ok()) << job.error().text();
  return {film.develop(), std::move(job).value()};
}

TEST(RenderLoop, SameBitsForAnyNumberOfThreads) {
  const auto scene = test::prepare(test::room());
  for (std::string_view method : method_names()) {
    const RenderSettings settings = small(std::string(method), test::kSanitized ? 4 : 12);
    const Outcome one = run(*scene, settings, 1);
    for (int threads : {2, 4}) {
      const Outcome many = run(*scene, settings, threads);
      EXPECT_TRUE(test::same_bits(one.image, many.image)) << method << " with " << threads;
      if (one.job.table) {
        EXPECT_EQ(encode_table(*one.job.table), encode_table(*many.job.table)) << method;
      }
    }
  }
}

TEST(RenderLoop, WhatIsSeenDirectlyIsWhatAPathOfOneSurfaceIsPaid) {
  const auto scene = test::included_scene("many-lights");
  RenderSettings settings = small("none", 4);
  const auto film_of = [&](int max_depth) {
    settings.max_depth = max_depth;
    auto film = std::make_unique<Film>(settings.width, settings.height);
    TaskPool pool(2);
    RenderObserver observer;
    EXPECT_TRUE(run_job(*scene, settings, {}, *film, pool, observer, {}, SteadyClock()).ok());
    return film;
  };
  const auto whole = film_of(8), one = film_of(1);
  const Image seen = whole->seen(), emitted = one->develop(), picture = whole->develop();
  EXPECT_GT(test::mean_luminance(seen), 0);
  EXPECT_LT(test::mean_luminance(seen), 0.9 * test::mean_luminance(picture));
  for (size_t i = 0; i < seen.data().size(); ++i) {
    ASSERT_NEAR(seen.data()[i], emitted.data()[i], 1e-5f * emitted.data()[i]);
    ASSERT_LE(seen.data()[i], picture.data()[i] * 1.00001f);
  }
}

TEST(RenderLoop, AQuarterIsThosePixelsOfTheWholePicture) {
  const auto scene = test::prepare(test::room());
  RenderSettings settings = small("none", 6);
  const Outcome all = run(*scene, settings, 2);
  settings.pixels = Pixels::kQuarter;
  const Outcome quarter = run(*scene, settings, 2);
  EXPECT_EQ(4 * quarter.job.stats.paths, all.job.stats.paths);
  for (int y = 0; y < settings.height; ++y)
    for (int x = 0; x < settings.width; ++x) {
      const Rgb expected = x % 2 || y % 2 ? Rgb{} : all.image.rgb(x, y);
      ASSERT_EQ(quarter.image.rgb(x, y), expected) << x << " " << y;
    }
}

TEST(RenderLoop, CountsByNoiseAreTheSameForAnyNumberOfThreadsAndInAllAsMany) {
  Scene half_lamp = test::room();  // half of the picture is a lamp, which has no noise
  const MaterialId lamp = test::add_material(half_lamp, Rgb{0.0f}, Rgb{1.0f});
  test::add_quad(half_lamp, lamp, {-1, 0, -0.9f}, {1, 0, 0}, {0, 2, 0});
  const auto scene = test::prepare(half_lamp);
  for (const auto& [method, pixels] : {std::pair{"none", Pixels::kByNoise},
                                       {"adaptive", Pixels::kByNoise},
                                       {"adaptive", Pixels::kAll}}) {
    RenderSettings even = small(method, 32);
    even.pixels = pixels == Pixels::kAll ? pixels : Pixels::kQuarter;
    even.adaptive.by_noise = false;
    const Outcome all_alike = run(*scene, even, 2);
    RenderSettings settings = small(method, 32);
    settings.pixels = pixels;
    settings.adaptive.by_noise = true;
    const Outcome one = run(*scene, settings, 1);
    EXPECT_TRUE(test::same_bits(one.image, run(*scene, settings, 3).image)) << method;
    EXPECT_FALSE(test::same_bits(one.image, all_alike.image)) << method;
    const auto paths = static_cast<double>(all_alike.job.stats.paths);
    EXPECT_NEAR(static_cast<double>(one.job.stats.paths), paths, 0.02 * paths);
    EXPECT_TRUE(one.job.stats.unbiased);
  }
}

TEST(RenderLoop, SeedsGiveOtherPictures) {
  const auto scene = test::prepare(test::room());
  RenderSettings settings = small("none", 1);
  const Outcome first = run(*scene, settings, 1);
  settings.seed = 2;
  EXPECT_FALSE(test::same_bits(first.image, run(*scene, settings, 1).image));
}

// What makes the same picture again without a clock.
RenderSettings replay_of(RenderSettings settings, const RenderStats& stats) {
  settings.seconds = 0;
  settings.passes = stats.passes;
  settings.last_pass_tiles = stats.last_pass_tiles;
  settings.pilot_samples = stats.pilot_samples;
  settings.learning_samples = static_cast<int>(stats.learning_samples_per_pixel);
  return settings;
}

TEST(RenderLoop, ATimedJobReplaysFromItsPasses) {
  const auto scene = test::prepare(test::room());
  RenderSettings settings = small("huang", 0);
  settings.seconds = 0.3;
  Outcome timed = run(*scene, settings, 2);
  for (; timed.job.stats.samples_per_pixel < 4 && settings.seconds < 60; settings.seconds *= 2)
    timed = run(*scene, settings, 2);  // however slow the machine is
  ASSERT_GT(timed.job.stats.samples_per_pixel, 3u);
  const RenderSettings replay = replay_of(settings, timed.job.stats);
  EXPECT_TRUE(test::same_bits(timed.image, run(*scene, replay, 1).image));
}

// Goes on by a millisecond whenever it is asked.
class CallClock final : public Clock {
 public:
  double seconds() const override { return 1e-3 * ++calls_; }

 private:
  mutable std::atomic<int> calls_ = 0;
};

TEST(RenderLoop, APilotHasItsShareOfTheTimeAndIsReplayed) {
  const auto scene = test::prepare(test::room());
  RenderSettings settings = small("adaptive", 0);
  settings.width = settings.height = 128;
  settings.nee = false;  // it is noisy
  int pilots[2];
  for (const double seconds : {1.0, 100.0}) {
    settings.seconds = seconds;
    settings.samples = 2;
    CallClock clock;
    Film film(settings.width, settings.height);
    TaskPool pool(1);
    RenderObserver nobody;
    const Result<JobResult> timed = run_job(*scene, settings, {}, film, pool, nobody, {}, clock);
    ASSERT_TRUE(timed.ok());
    const RenderStats& stats = timed.value().stats;
    pilots[seconds > 1] = stats.pilot_samples;
    const Outcome replayed = run(*scene, replay_of(settings, stats), 2);
    EXPECT_TRUE(test::same_bits(film.develop(), replayed.image)) << seconds;
    EXPECT_EQ(replayed.job.stats.pilot_samples, stats.pilot_samples);
  }
  EXPECT_GE(pilots[0], 2) << "its noise is known";
  EXPECT_LT(pilots[0], pilots[1]);
}

// A sample of all four tiles takes four seconds.
TEST(RenderLoop, TimeIsUsedUpByAPassThatEndsWithIt) {
  const auto scene = test::prepare(test::room());
  for (const char* method : {"none", "adaptive"}) {
    RenderSettings settings = small(method, 0);
    settings.seconds = 10.5;
    test::TileClock clock;
    Film film(settings.width, settings.height);
    TaskPool pool(1);
    const Result<JobResult> timed = run_job(*scene, settings, {}, film, pool, clock, {}, clock);
    ASSERT_TRUE(timed.ok());
    const RenderStats& stats = timed.value().stats;
    EXPECT_EQ(clock.seconds(), 11) << "the tile under way when time was up";
    EXPECT_EQ(stats.passes, (std::vector<int>{1, 1, 1}));
    EXPECT_EQ(stats.last_pass_tiles, 3);
    EXPECT_EQ(stats.samples_per_pixel, 2u);
    const Outcome replayed = run(*scene, replay_of(settings, stats), 2);
    EXPECT_TRUE(test::same_bits(film.develop(), replayed.image)) << method;
    EXPECT_EQ(replayed.job.stats.paths, stats.paths);
    EXPECT_EQ(replayed.job.stats.last_pass_tiles, 3);
  }
}

TEST(RenderLoop, PassesGrowAndEndAtTheSamplesAskedFor) {
  const auto scene = test::prepare(test::room());
  const Outcome outcome = run(*scene, small("none", 13), 2);
  EXPECT_EQ(outcome.job.stats.passes, (std::vector<int>{1, 1, 1, 1, 2, 2, 4, 1}));
  EXPECT_EQ(outcome.job.stats.samples_per_pixel, 13u);
  EXPECT_EQ(outcome.job.stats.paths, 13u * 100 * 70);
  EXPECT_EQ(outcome.job.stats.dropped_samples, 0u);
}

TEST(RenderLoop, LearnsForHalfOfTheJobAtMost) {
  const auto scene = test::prepare(test::room());
  EXPECT_EQ(run(*scene, small("huang", 16), 2).job.stats.learning_samples_per_pixel, 8u);
  EXPECT_EQ(run(*scene, small("none", 16), 2).job.stats.learning_samples_per_pixel, 0u);
}

TEST(RenderLoop, SaysWhichPartsAreOffAndWhy) {
  RenderSettings settings = small("huang", 1);
  settings.max_depth = 16;
  Scene scene = test::room();
  auto parts = run(*test::prepare(scene), settings, 1).job.stats.parts;
  EXPECT_EQ(parts["nee"], "on");
  EXPECT_EQ(parts["light_table"], "off: all lights are equally strong");  // one panel's two halves
  EXPECT_EQ(parts["russian_roulette"], "on");
  EXPECT_EQ(parts["guide"], "on");
  EXPECT_EQ(parts["mixing"], "off: all surfaces that are guided are diffuse");

  for (Material& m : scene.materials) m.emission.value = Rgb{};
  scene.materials[1].kind = MaterialKind::kPlastic;
  settings.method = "none";
  settings.russian_roulette = false;
  parts = run(*test::prepare(scene), settings, 1).job.stats.parts;
  EXPECT_EQ(parts["nee"], "off: the scene has no lights");
  EXPECT_EQ(parts["russian_roulette"], "off: not asked for");
  EXPECT_EQ(parts["mixing"], "off: the method has no guide");
}

TEST(RenderLoop, SharesOfTimeSumToOne) {
  const auto scene = test::prepare(test::room());
  const RenderStats stats = run(*scene, small("huang", 8), 2).job.stats;
  EXPECT_GT(stats.share_tracing, 0);
  EXPECT_GT(stats.share_guiding, 0);
  EXPECT_GT(stats.share_rest, 0);
  EXPECT_NEAR(stats.share_tracing + stats.share_guiding + stats.share_rest, 1, 1e-9);
}

TEST(RenderLoop, NonFiniteSamplesAreDroppedAndCounted) {
  Scene scene = test::room();
  const auto clean = test::prepare(scene);
  auto prepared = std::const_pointer_cast<PreparedScene>(test::prepare(scene));
  // Not possible from a file: validate() refuses it.
  prepared->scene.materials[2].emission.value = Rgb{std::numeric_limits<float>::infinity()};
  const Outcome outcome = run(*prepared, small("none", 4), 2);
  EXPECT_GT(outcome.job.stats.dropped_samples, 0u);
  for (float v : outcome.image.data()) EXPECT_TRUE(std::isfinite(v));
}

class StopAtFirstTile final : public RenderObserver {
 public:
  explicit StopAtFirstTile(std::stop_source& source) : source_(source) {}
  void on_tile(const RenderProgress&) override {
    source_.request_stop();
    ++tiles;
  }
  std::atomic<int> tiles = 0;

 private:
  std::stop_source& source_;
};

TEST(RenderLoop, StopsInMidPass) {
  const auto scene = test::prepare(test::room());
  RenderSettings settings = small("huang", 100'000);
  settings.width = settings.height = 512;
  Film film(settings.width, settings.height);
  TaskPool pool(2);
  std::stop_source source;
  StopAtFirstTile observer(source);
  const Result<JobResult> job =
      run_job(*scene, settings, {}, film, pool, observer, source.get_token(), SteadyClock());
  ASSERT_FALSE(job.ok());
  EXPECT_EQ(job.error().code, ErrorCode::kCanceled);
  EXPECT_LE(observer.tiles, 2);
}

class Recorder final : public RenderObserver {
 public:
  void on_tile(const RenderProgress& p) override { fractions.push_back(p.fraction); }
  void on_pass(const RenderProgress& p, const RenderStats& so_far, const Guide*) override {
    passes.push_back(p.samples_per_pixel);
    rays.push_back(so_far.rays);
  }
  std::vector<double> fractions;
  std::vector<uint64_t> passes, rays;
};

TEST(RenderLoop, ProgressRisesToOne) {
  const auto scene = test::prepare(test::room());
  const RenderSettings settings = small("huang", 8);
  Film film(settings.width, settings.height);
  TaskPool pool(3);
  Recorder recorder;
  const auto job = run_job(*scene, settings, {}, film, pool, recorder, {}, SteadyClock());
  ASSERT_TRUE(job.ok());
  EXPECT_TRUE(std::is_sorted(recorder.fractions.begin(), recorder.fractions.end()));
  EXPECT_DOUBLE_EQ(recorder.fractions.back(), 1);
  EXPECT_EQ(recorder.passes, (std::vector<uint64_t>{1, 2, 3, 4, 6, 8}));
  EXPECT_TRUE(std::is_sorted(recorder.rays.begin(), recorder.rays.end()));
  EXPECT_GT(recorder.rays.front(), 0u);
  EXPECT_EQ(recorder.rays.back(), job.value().stats.rays);
}

TEST(RunJob, TableGrowsFromItsParent) {
  const auto scene = test::prepare(test::room());
  const Outcome cold = run(*scene, small("huang", 8), 2);
  ASSERT_TRUE(cold.job.table);
  EXPECT_TRUE(table_fits(cold.job.table->header, scene->hash));
  EXPECT_TRUE(cold.job.table->header.parents.empty());
  const Outcome warm = run(*scene, small("huang", 8), 2, cold.job.table);
  EXPECT_EQ(warm.job.table->header.parents, std::vector<std::string>{cold.job.table->header.id});
  EXPECT_GT(warm.job.table->header.samples_seen, cold.job.table->header.samples_seen);
  EXPECT_NE(warm.job.table->header.id, cold.job.table->header.id);
  EXPECT_FALSE(test::same_bits(cold.image, warm.image));
}

TEST(RunJob, ATableOfAnotherMethodOrGridIsRefused) {
  const auto scene = test::prepare(test::room());
  const Outcome cold = run(*scene, small("huang", 2), 2);
  Film film(100, 70);
  TaskPool pool(1);
  RenderObserver observer;
  Result<JobResult> none =
      run_job(*scene, small("none", 1), cold.job.table, film, pool, observer, {}, SteadyClock());
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().code, ErrorCode::kInvalid);
  RenderSettings fine = small("huang", 1);
  fine.huang.grid = 100;
  Result<JobResult> other =
      run_job(*scene, fine, cold.job.table, film, pool, observer, {}, SteadyClock());
  ASSERT_FALSE(other.ok());
  EXPECT_EQ(other.error().code, ErrorCode::kConflict);
}

}  // namespace
}  // namespace qray
