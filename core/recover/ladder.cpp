#include "core/recover/ladder.h"

#include <algorithm>
#include <ctime>
#include <numeric>

#include "core/math/hash.h"
#include "core/math/vec.h"

namespace qray {
namespace {

constexpr double kTolerated = 1.05;
constexpr int kDraws = 2000;
constexpr double kSure = 0.9;

double cpu_seconds() {  // of all threads
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

Rung untaught(const std::string& name, Network net, std::span<const TrainingView> views,
              TaskPool& pool) {
  std::vector<double> errors(views.size());
  pool.run(views.size(), [&](size_t i, int) { errors[i] = cleaning_error(net, views[i]); });
  return {name, std::move(net), 0, 0, std::move(errors)};
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

Result<Ladder> climb(Rung first, std::span<const TrainingView> views, size_t held_out,
                     const TrainOptions& options, TaskPool& pool, std::stop_token stop,
                     const std::function<void(const TrainProgress&)>& on_step) {
  const std::span<const TrainingView> kept = views.last(held_out);
  Ladder ladder;
  ladder.rungs.push_back(untaught("untrained", untrained_network(options.seed), kept, pool));
  ladder.rungs.push_back(untaught(first.name, first.network, kept, pool));
  const double start = cpu_seconds();
  Result<Trained> trained =
      train(first.network, views, held_out, options, pool, std::move(stop), on_step);
  if (!trained) return trained.error();
  Trained& t = trained.value();
  Network mean = std::move(first.network);
  for (size_t i = 0; i < mean.values.size(); ++i)
    mean.values[i] = lerp(0.5f, mean.values[i], t.network.values[i]);
  const double took = cpu_seconds() - start;
  ladder.rungs.push_back(untaught("mean", std::move(mean), kept, pool));
  ladder.rungs.push_back({"trained", std::move(t.network), 0, 0, std::move(t.held_out)});
  for (size_t i = 2; i < 4; ++i)
    ladder.rungs[i].steps = options.steps, ladder.rungs[i].cpu_seconds = took;
  ladder.chosen = cheapest_good(ladder.rungs, options.seed);
  return ladder;
}

}  // namespace qray
