// Teaches a network by training views: Adam (Kingma and Ba 2015), batches of 8 tiles, each turned
// by chance, with its colour channels exchanged and the world's axes exchanged and mirrored. The
// same views, options and seed give the same values for any number of threads.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/result.h"
#include "core/base/task_pool.h"
#include "core/recover/pyramid.h"
#include "core/recover/training_view.h"

namespace qray {

struct TrainOptions {
  int steps = 600;
  uint64_t seed = 1;
};

struct TrainProgress {
  int step = 0;
  double loss = 0;      // of the batch, smoothed
  double held_out = 0;  // error of the views kept apart, when last looked at
  // At a look, and only then: what training would return if it ended here.
  std::span<const float> values{};
};

struct Trained {
  Network network;               // a moving mean of the values of the last hundreds of steps
  std::vector<double> held_out;  // relMSE of each view kept apart
};

// kCanceled when stopped. `views`: squares of equal, even size, at least 64 pixels; the last
// `held_out` of them (1 at least) are kept apart.
Result<Trained> train(Network start, std::span<const TrainingView> views, size_t held_out,
                      const TrainOptions& options, TaskPool& pool, std::stop_token stop,
                      const std::function<void(const TrainProgress&)>& on_step);

// relMSE of a picture of the view, what is the target's own left out: it may be below 0.
double picture_error(const Image& picture, const TrainingView& view);
// The same of all pixels of the view, cleaned by the network.
double cleaning_error(const Network& net, const TrainingView& view);

}  // namespace qray
