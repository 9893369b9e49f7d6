// What recovery takes: a picture by the network, of all pixels and of a quarter, the features it
// needs of a scene, and a step of training.
#include <benchmark/benchmark.h>

#include "core/job/load_and_prepare.h"
#include "core/math/hash.h"
#include "core/recover/guess.h"
#include "core/recover/recover.h"
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

RecoveryInput random_input(int width, int height) {
  RecoveryInput input;
  input.features = random_image(width, height, kFeatures, 1);
  input.colour = random_image(width, height, 3, 2);
  input.noise = random_image(width, height, 1, 3);
  input.own_error = random_image(width, height, 1, 4);
  return input;
}

// Arguments: width, height, threads.
void RecoverAll(benchmark::State& state) {
  const RecoveryInput input =
      random_input(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  const Network net = untrained_network(1);
  TaskPool pool(static_cast<int>(state.range(2)));
  for (auto _ : state) benchmark::DoNotOptimize(recover_all(net, input, pool));
}
BENCHMARK(RecoverAll)
    ->Args({512, 512, 1})
    ->Args({512, 512, 2})
    ->Args({1920, 1080, 2})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

// Of a live frame; arguments as above.
void GuessQuarter(benchmark::State& state) {
  const int width = static_cast<int>(state.range(0)), height = static_cast<int>(state.range(1));
  const RecoveryInput known = random_input(width / 2, height / 2);
  const Image features = random_image(width, height, kFeatures, 5);
  Guess guess(untrained_network(1));
  TaskPool pool(static_cast<int>(state.range(2)));
  for (auto _ : state) benchmark::DoNotOptimize(guess.of_quarter(known, features, pool));
}
BENCHMARK(GuessQuarter)
    ->Args({512, 512, 1})
    ->Args({512, 512, 2})
    ->Args({1920, 1080, 2})
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
    views.push_back({random_input(128, 128), random_image(128, 128, 3, 9 + i), 0});
  TaskPool pool(1);
  TrainOptions options;
  options.steps = 10;
  for (auto _ : state)
    benchmark::DoNotOptimize(
        train(untrained_network(1), views, 1, options, pool, {}, [](const TrainProgress&) {}));
  state.counters["ms a step"] = benchmark::Counter(
      static_cast<double>(options.steps),
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(TrainingStep)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace qray
