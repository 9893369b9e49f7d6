// No more model than the scene needs: a filter that nobody trained, a network that is there
// already, or one that is trained for the scene. The cheapest whose held-out error is within 5 % of
// the best's, as far as the views can tell.
#pragma once

#include <string>

#include "core/recover/train.h"

namespace qray {

struct Rung {
  std::string name;
  Network network;
  int steps = 0;                   // of training
  double cpu_seconds = 0;          // of it
  std::vector<double> held_out{};  // relMSE of each view kept apart
  double mean_held_out() const;
};

// From the least up: "untrained", the one that was there, "mean", "trained".
struct Ladder {
  std::vector<Rung> rungs;
  size_t chosen = 0;
};

// As train(). `first`: a network that is there, with a name, from which training goes on.
Result<Ladder> climb(Rung first, std::span<const TrainingView> views, size_t held_out,
                     const TrainOptions& options, TaskPool& pool, std::stop_token stop,
                     const std::function<void(const TrainProgress&)>& on_step);

// The first rung whose mean error is at most 1.05 times the best's in 9 of 10 draws of the views
// (a paired bootstrap). All with as many errors, of the same views.
size_t cheapest_good(std::span<const Rung> rungs, uint64_t seed);

}  // namespace qray
