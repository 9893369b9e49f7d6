// What a job's size can do to a method: one pixel, one row, one sample, hours that end at once.
#include <gtest/gtest.h>

#include <numeric>

#include "tests/stability/compare.h"
#include "tests/stability/huang_table.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

using test::formatted;

TEST(Picture, OnePixelAndOneRow) {
  const test::FailureMode mode("one-pixel-one-row");
  const auto scene = test::prepare(test::room());
  struct Shape {
    const char* name;
    int width, height, samples;
  };
  for (const Shape& shape :
       {Shape{"1x1", 1, 1, 4096}, Shape{"8192x1", 8192, 1, 2}, Shape{"1x8192", 1, 8192, 2}}) {
    RenderSettings settings = test::small_settings("none", 1, shape.samples);
    settings.width = shape.width;
    settings.height = shape.height;
    const test::SeedOptions options{.seeds = 24, .regions = 1, .table = {}};
    const test::Sampled none = test::sample_seeds(*scene, settings, "none", options);
    EXPECT_GT(none.mean(), 0);
    test::check_method(mode, shape.name, none, none, nullptr);
    for (const std::string& method : test::learning_methods())
      test::check_method(mode, shape.name, test::sample_seeds(*scene, settings, method, options),
                         none, nullptr);
  }
}

TEST(Picture, OneSample) {
  const test::FailureMode mode("one-sample");
  const auto scene = test::prepare(test::room());
  const RenderSettings settings = test::small_settings("none", 32, 1);
  test::SeedOptions options{.seeds = 128, .regions = 2, .table = {}, .guide_rules = false};
  test::check_methods(mode, "without a table", *scene, settings, options);
  options.seeds = 96;
  options.guide_rules = true;
  options.table = [&](const std::string& variant) {
    return test::learned_table(*scene, settings, variant);
  };
  test::check_methods(mode, "from a learned table", *scene, settings, options);
}

// Asks for a stop within a pass, after so many tiles.
class StopAfter : public RenderObserver {
 public:
  explicit StopAfter(int tiles) : left_(tiles) {}
  void on_tile(const RenderProgress&) override {
    ++tiles_;
    if (--left_ == 0) source_.request_stop();
  }
  std::stop_token token() const { return source_.get_token(); }
  int tiles() const { return tiles_; }

 private:
  std::stop_source source_;
  int left_, tiles_ = 0;
};

// The hands move on by themselves whenever someone looks.
class TurningClock : public Clock {
 public:
  double seconds() const override { return now_ += 0.02; }

 private:
  mutable double now_ = 0;
};

TEST(Picture, AnHoursJobStopped) {
  const test::FailureMode mode("job-cut-short");
  const auto scene = test::prepare(test::room());
  constexpr int kTiles = 6, kStopAfter = 20;  // in the fourth pass
  for (const std::string& method : test::compared_methods()) {
    RenderSettings settings = test::variant_settings(method, 0, 0);
    settings.width = 192;
    settings.height = 128;
    settings.seconds = 3600;
    Film film(settings.width, settings.height);
    TaskPool pool(2);
    StopAfter observer(kStopAfter);
    const Result<JobResult> job =
        run_job(*scene, settings, {}, film, pool, observer, observer.token(), SteadyClock());
    ASSERT_FALSE(job.ok()) << method;
    EXPECT_EQ(job.error().code, ErrorCode::kCanceled) << method;
    // The other thread may have been at the end of a tile.
    EXPECT_GE(observer.tiles(), kStopAfter) << method;
    EXPECT_LE(observer.tiles(), kStopAfter + 1) << method;
    EXPECT_EQ(film.version(), static_cast<uint64_t>(observer.tiles())) << method;
    for (const Film::TileView& tile : film.tiles_since(0, kTiles).tiles) {
      EXPECT_GT(tile.samples, 0u) << method;
      for (Rgb c : tile.mean) ASSERT_TRUE(is_finite(c)) << method;
    }
    EXPECT_EQ(film.tiles_since(0, kTiles).tiles.size(), static_cast<size_t>(kTiles)) << method;

    settings.width = settings.height = 32;
    settings.seconds = 1;
    settings.samples = 1'000'000;
    Film cut(32, 32);
    RenderObserver nobody;
    const Result<JobResult> done =
        run_job(*scene, settings, {}, cut, pool, nobody, {}, TurningClock());
    ASSERT_TRUE(done.ok()) << method;
    const RenderStats& stats = done.value().stats;
    EXPECT_GT(stats.samples_per_pixel, 1u) << method;
    EXPECT_LT(stats.samples_per_pixel, 100'000u) << method;
    EXPECT_EQ(std::accumulate(stats.passes.begin(), stats.passes.end(), uint64_t{0}),
              stats.samples_per_pixel);
    EXPECT_EQ(stats.paths, stats.samples_per_pixel * 32 * 32) << method;
    RenderSettings replay = settings;
    replay.passes = stats.passes;
    replay.learning_samples = static_cast<int>(stats.learning_samples_per_pixel);
    const test::Rendered again = test::render(*scene, replay);
    const Image first = cut.develop();
    EXPECT_TRUE(std::equal(first.data().begin(), first.data().end(), again.image.data().begin()))
        << method;
    mode.says(method,
              formatted("stopped within a pass, it keeps the finished tiles; ended by its limit "
                        "after %d samples a pixel, it is replayed bit for bit",
                        static_cast<int>(stats.samples_per_pixel)));
  }
}

}  // namespace
}  // namespace qray
