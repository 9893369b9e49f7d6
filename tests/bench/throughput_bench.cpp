// The path tracer's rays per second against the same rays traced by bare Embree loops, one after
// the other in the same run, so that a busy or throttled machine slows both.
#include <benchmark/benchmark.h>

#include <algorithm>

#include "core/job/load_and_prepare.h"
#include "core/job/run_job.h"
#include "tests/bench/ray_recorder.h"
#include "tests/support/places.h"

namespace qray::bench {
namespace {

RenderSettings plain_settings(int width, int samples) {
  RenderSettings settings;
  settings.method = "none";
  settings.width = settings.height = width;
  settings.passes = {samples};
  settings.max_depth = 8;
  return settings;
}

std::optional<RenderStats> render_once(const PreparedScene& scene, const RenderSettings& settings,
                                       TaskPool& pool) {
  Film film(settings.width, settings.height);
  RenderObserver observer;
  const Result<JobResult> done = run_job(scene, settings, std::nullopt, film, pool, observer,
                                         std::stop_token(), SteadyClock());
  if (!done) return std::nullopt;
  return done.value().stats;
}

double replay_seconds(const std::vector<RecordedRay>& rays, TaskPool& pool) {
  constexpr size_t kBlock = 1 << 14;
  const SteadyClock clock;
  const double start = clock.seconds();
  pool.run((rays.size() + kBlock - 1) / kBlock, [&](size_t block, int) {
    benchmark::DoNotOptimize(
        replay(rays, block * kBlock, std::min(rays.size(), (block + 1) * kBlock)));
  });
  return clock.seconds() - start;
}

// An iteration renders and replays once. Counters are millions of rays a second, medians of the
// iterations, and their ratio. `path`: of a scene, from the source's root.
void PathTracerAgainstBareRays(benchmark::State& state, const char* path) {
  constexpr int kWidth = 512, kSamples = 2;
  const int threads = static_cast<int>(state.range(0));
  const auto prepared = load_and_prepare_scene(test::source_dir() / path, threads);
  if (!prepared) return state.SkipWithError(prepared.error().text().c_str());
  const PreparedScene& scene = *prepared.value();
  const RenderSettings settings = plain_settings(kWidth, kSamples);

  std::vector<RecordedRay> rays;
  {
    TaskPool one_thread(1);
    const RayRecorder recorder(rays);
    const auto stats = render_once(scene, settings, one_thread);
    if (!stats || stats->rays != rays.size())
      return state.SkipWithError("the recorded rays are not those that the renderer counts");
  }
  TaskPool pool(threads);
  std::vector<double> traced, bare, ratio;
  for (auto _ : state) {
    const auto stats = render_once(scene, settings, pool);
    const double seconds = replay_seconds(rays, pool);
    traced.push_back(stats->rays_per_second() * 1e-6);
    bare.push_back(static_cast<double>(rays.size()) / seconds * 1e-6);
    ratio.push_back(traced.back() / bare.back());
    state.SetIterationTime(stats->seconds + seconds);
  }
  const auto median = [](std::vector<double>& values) {
    std::nth_element(values.begin(), values.begin() + static_cast<long>(values.size() / 2),
                     values.end());
    return values[values.size() / 2];
  };
  state.counters["path_Mrays_s"] = median(traced);
  state.counters["bare_Mrays_s"] = median(bare);
  state.counters["ratio"] = median(ratio);
  state.counters["rays_per_path"] = static_cast<double>(rays.size()) / (kWidth * kWidth * kSamples);
}
void one_thread_and_two(benchmark::internal::Benchmark* bench) {
  bench->ArgName("threads")->Arg(1)->Arg(2)->Iterations(20)->UseManualTime()->Unit(
      benchmark::kMillisecond);
}
// The aims: at least 0.75 and 0.85.
BENCHMARK_CAPTURE(PathTracerAgainstBareRays, cornell_box, "scenes/cornell-box/scene.json")
    ->Apply(one_thread_and_two);
BENCHMARK_CAPTURE(PathTracerAgainstBareRays, fine_ball, "tests/bench/scenes/fine-ball.json")
    ->Apply(one_thread_and_two);

}  // namespace
}  // namespace qray::bench
