// What recovery takes: a picture by the network (bars: 8 ms for 512x512 and 70 ms for 1920x1080 on
// two threads), the features it needs of a scene, and a step of training.
#include <benchmark/benchmark.h>

#include "core/job/load_and_prepare.h"
#include "core/math/hash.h"
#include "core/recover/fast_recovery.h"
#include "core/recover/train.h"
#include "core/render/features.h"
#include "tests/support/places.h"

namespace qray {
namespace {

Image random_image(int width, int height, int channels, uint64_t seed) {
  Image image(width, height, channels);
  for (size_t i = 0; i < image.data().size(); ++i)
    image.data()[i] = to_unit_float(static_cast<uint32_t>(mix64(seed + i)));
  return image;
}

// Arguments: width, height, hidden units, threads.
void RecoverPicture(benchmark::State& state) {
  const int width = static_cast<int>(state.range(0)), height = static_cast<int>(state.range(1));
  const Image features = random_image(width, height, kFeatures, 1),
              input = random_image(width, height, 3, 2), noise = random_image(width, height, 1, 3);
  FastRecovery recovery(untrained_network(static_cast<int>(state.range(2)), 1), width, height);
  TaskPool pool(static_cast<int>(state.range(3)));
  for (auto _ : state) benchmark::DoNotOptimize(recovery.run(features, input, noise, pool));
}
BENCHMARK(RecoverPicture)
    ->Args({512, 512, 16, 1})
    ->Args({512, 512, 16, 2})
    ->Args({512, 512, 32, 2})
    ->Args({1920, 1080, 16, 2})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void Features(benchmark::State& state) {
  TaskPool pool(2);
  const auto scene =
      load_and_prepare_scene(test::source_dir() / "scenes/thesis-room/scene.json", 2).value();
  RenderSettings settings;
  for (auto _ : state)
    benchmark::DoNotOptimize(render_features(*scene, settings, pool, std::stop_token()));
}
BENCHMARK(Features)->Unit(benchmark::kMillisecond)->UseRealTime();

void TrainingStep(benchmark::State& state) {
  std::vector<TrainingView> views;
  for (uint64_t i = 0; i < 4; ++i)
    views.push_back({{random_image(128, 128, kFeatures, 4 * i),
                      random_image(128, 128, 3, 4 * i + 1), random_image(128, 128, 1, 4 * i + 2)},
                     random_image(128, 128, 3, 4 * i + 3),
                     0});
  TaskPool pool(1);
  TrainOptions options;
  options.steps = 10;
  for (auto _ : state)
    benchmark::DoNotOptimize(train(untrained_network(static_cast<int>(state.range(0)), 1), views, 1,
                                   options, pool, {}, [](const TrainProgress&) {}));
  state.counters["ms a step"] = benchmark::Counter(
      static_cast<double>(options.steps),
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(TrainingStep)->Arg(16)->Arg(32)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace qray
