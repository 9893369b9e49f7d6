#include "core/recover/ladder.h"

#include <algorithm>
#include <ctime>
#include <numeric>

#include "core/math/hash.h"
#include "core/recover/bilinear.h"
#include "core/recover/included_networks.h"

namespace qray {
namespace {

constexpr double kTolerated = 1.05;
constexpr int kDraws = 2000;
constexpr double kSure = 0.9;

double cpu_seconds() {  // of all threads
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

std::vector<double> errors_of(const Network& net, std::span<const TrainingView> views) {
  std::vector<double> errors;
  for (const TrainingView& view : views)
    errors.push_back(net.hidden == 0 ? picture_error(bilinear_recovery(view.input.colour), view)
                                     : recovery_error(net, view));
  return errors;
}

}  // namespace

double Rung::mean_held_out() const {
  return std::accumulate(held_out.begin(), held_out.end(), 0.0) /
         static_cast<double>(held_out.size());
}

size_t cheapest_good(std::span<const Rung> rungs, uint64_t seed) {
  const auto best = std::min_element(rungs.begin(), rungs.end(), [](const Rung& a, const Rung& b) {
    return a.mean_held_out() < b.mean_held_out();
  });
  const size_t views = best->held_out.size();
  for (size_t r = 0; r < rungs.size(); ++r) {
    int good = 0;
    uint64_t bits = seed;
    for (int draw = 0; draw < kDraws; ++draw) {
      double mine = 0, least = 0;
      for (size_t k = 0; k < views; ++k) {
        bits = mix64(bits + 1);
        const size_t view = (bits >> 32) * views >> 32;
        mine += rungs[r].held_out[view];
        least += best->held_out[view];
      }
      good += mine <= kTolerated * least;
    }
    if (good >= kSure * kDraws) return r;
  }
  return static_cast<size_t>(best - rungs.begin());
}

Result<Ladder> climb(std::span<const TrainingView> views, size_t held_out,
                     const TrainOptions& options, TaskPool& pool, std::stop_token stop,
                     const std::function<void(const std::string&, const TrainProgress&)>& on_step) {
  const std::span<const TrainingView> kept = views.last(held_out);
  Ladder ladder;
  for (const auto& [name, net] : {std::pair{"bilinear", no_network()},
                                  std::pair{"untrained", untrained_network(16, options.seed)}})
    ladder.rungs.push_back({name, net, 0, 0, errors_of(net, kept)});
  for (int hidden : {16, 32}) {
    const std::string name = std::to_string(hidden) + " hidden";
    const double start = cpu_seconds();
    Result<Trained> trained =
        train(untrained_network(hidden, options.seed), views, held_out, options, pool, stop,
              [&](const TrainProgress& progress) { on_step(name, progress); });
    if (!trained) return trained.error();
    Trained& t = trained.value();
    ladder.rungs.push_back(
        {name, std::move(t.network), t.steps, cpu_seconds() - start, std::move(t.held_out)});
  }
  ladder.chosen = cheapest_good(ladder.rungs, options.seed);
  return ladder;
}

}  // namespace qray
