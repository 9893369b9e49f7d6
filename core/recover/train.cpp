#include "core/recover/train.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/base/check.h"
#include "core/image/metrics.h"
#include "core/math/hash.h"
#include "core/recover/tile_pass.h"

namespace qray {
namespace {

constexpr int kBatch = 8;
constexpr int kTileBlocks = 32;  // a side
constexpr float kRate = 3e-3f, kBeta1 = 0.9f, kBeta2 = 0.99f, kLastRate = 0.02f;
constexpr float kScalesRate = 6;  // times the rate
constexpr int kWarmUp = 20;       // steps
constexpr double kMostGradient = 1;
constexpr double kLeastLoss = 1e-3;      // of a tile, as it is weighted
constexpr int kLook = 200;               // steps between looks at the views kept apart; of the fall
constexpr double kLeastGain = 0.02;      // of their error, from one look to the next
constexpr double kDarkestSquare = 0.01;  // of squared means, in relMSE

struct Choice {
  size_t view;
  int y, x;
  Flip flip;
};

// A batch's tiles, from the seed and the step alone.
Choice choose(uint64_t seed, int step, int tile, std::span<const TrainingView> views) {
  uint64_t bits = mix64(mix64(seed) + static_cast<uint64_t>(step * kBatch + tile));
  const auto below = [&](int n) {
    bits = mix64(bits + 1);
    return static_cast<int>(bits >> 33) % n;
  };
  Choice c{static_cast<size_t>(below(static_cast<int>(views.size()))), 0, 0, {}};
  const int room = views[c.view].features.width() / 2 - kTileBlocks + 1;
  c.y = below(room), c.x = below(room);
  const int flip = below(8);
  c.flip = {(flip & 1) != 0, (flip & 2) != 0, (flip & 4) != 0};
  return c;
}

// One tile of a batch: its own memory, so that threads share nothing.
struct TileWork {
  TilePass pass;
  std::vector<float> d_result, gradient;
  double loss = 0;

  void run(const Network& net, const TrainingView& view, const Choice& c, Loss kind,
           std::span<const float> back2, std::span<const float> back3) {
    gradient.assign(net.values.size(), 0);
    const BlockTile tile =
        tile_of(view.features, view.input, view.noise, c.y, c.x, kTileBlocks, kTileBlocks, c.flip);
    const std::vector<float> target = target_of(view, c.y, c.x, kTileBlocks, kTileBlocks, c.flip);
    loss = loss_of(kind, pass.forward(net, tile), tile.albedo, target, d_result);
    // The gradient of the loss' logarithm: a dark noisy view counts no more than a clean one.
    for (float& d : d_result) d /= static_cast<float>(loss + kLeastLoss);
    pass.backward(net, tile, d_result, back2, back3, gradient);
  }
};

class Adam {
 public:
  explicit Adam(size_t size) : first_(size), second_(size) {}

  // The mean of the batch's gradients, shortened to kMostGradient.
  void step(Network& net, std::span<TileWork> batch, float rate) {
    std::vector<float>& mean = batch[0].gradient;
    double square = 0;
    for (size_t i = 0; i < mean.size(); ++i) {
      for (size_t k = 1; k < batch.size(); ++k) mean[i] += batch[k].gradient[i];
      mean[i] /= static_cast<float>(batch.size());
      square += static_cast<double>(mean[i]) * static_cast<double>(mean[i]);
    }
    const float shorten =
        static_cast<float>(std::min(1.0, kMostGradient / std::sqrt(square + 1e-20)));
    power1_ *= kBeta1, power2_ *= kBeta2;
    const size_t scales = net.parts().scales;
    for (size_t i = 0; i < mean.size(); ++i) {
      const float g = mean[i] * shorten;
      first_[i] = kBeta1 * first_[i] + (1 - kBeta1) * g;
      second_[i] = kBeta2 * second_[i] + (1 - kBeta2) * g * g;
      net.values[i] -= (i >= scales ? kScalesRate * rate : rate) * (first_[i] / (1 - power1_)) /
                       (std::sqrt(second_[i] / (1 - power2_)) + 1e-8f);
    }
  }

 private:
  std::vector<float> first_, second_;
  float power1_ = 1, power2_ = 1;
};

// The rate rises at first and, in the last steps, falls along a cosine to kLastRate of its height.
class Schedule {
 public:
  explicit Schedule(int steps) : end_(steps), fall_(std::max(0, steps - kLook)) {}

  void end_soon(int step) {
    if (step >= fall_) return;
    fall_ = step;
    end_ = step + kLook;
  }
  int end() const { return end_; }
  float rate(int step) const {
    const float part =
        std::max(0.0f, static_cast<float>(step - fall_) / static_cast<float>(end_ - fall_));
    const float height = 0.5f * (1 - kLastRate) * (1 + std::cos(std::numbers::pi_v<float> * part));
    return kRate * std::min(1.0f, static_cast<float>(step + 1) / kWarmUp) * (height + kLastRate);
  }

 private:
  int end_, fall_;
};

std::vector<double> errors_of(const Network& net, std::span<const TrainingView> views,
                              TaskPool& pool) {
  std::vector<double> errors(views.size());
  pool.run(views.size(), [&](size_t i, int) { errors[i] = recovery_error(net, views[i]); });
  return errors;
}

double mean_of(const std::vector<double>& v) {
  return std::accumulate(v.begin(), v.end(), 0.0) / static_cast<double>(v.size());
}

}  // namespace

double picture_error(const Image& picture, const TrainingView& view) {
  return relmse(picture, view.target) - view.target_relmse;
}

double recovery_error(const Network& net, const TrainingView& view) {
  const int height = view.features.height() / 2, width = view.features.width() / 2;
  const BlockTile tile = tile_of(view.features, view.input, view.noise, 0, 0, height, width);
  const std::vector<float> target = target_of(view, 0, 0, height, width, {});
  TilePass pass;
  const std::span<const float> result = pass.forward(net, tile);
  double sum = 0;
  for (size_t i = 0; i < result.size(); ++i) {
    const double t = static_cast<double>(target[i]);
    const double difference = static_cast<double>(result[i] * tile.albedo[i]) - t;
    sum += difference * difference / (t * t + kDarkestSquare);
  }
  return sum / static_cast<double>(result.size()) - view.target_relmse;
}

Result<Trained> train(Network start, std::span<const TrainingView> views, size_t held_out,
                      const TrainOptions& options, TaskPool& pool, std::stop_token stop,
                      const std::function<void(const TrainProgress&)>& on_step) {
  QRAY_CHECK(held_out >= 1 && views.size() > held_out);
  const std::span<const TrainingView> taught = views.first(views.size() - held_out);
  const std::span<const TrainingView> kept = views.last(held_out);
  Trained trained{std::move(start), 0, {}};
  Network& net = trained.network;
  const Network::Parts at = net.parts();
  Adam adam(net.values.size());
  std::vector<TileWork> batch(kBatch);
  Schedule schedule(options.steps);
  TrainProgress progress{0, options.steps, 0, 0};
  trained.held_out = errors_of(net, kept, pool);
  double before = progress.held_out = mean_of(trained.held_out);
  while (trained.steps < schedule.end()) {
    if (stop.stop_requested()) return Error{ErrorCode::kCanceled, "canceled", ""};
    const std::vector<float> back2 =
        transposed(&net.values[at.weights2], kTaps, net.hidden, net.hidden);
    const std::vector<float> back3 = transposed(&net.values[at.weights3], 1, net.hidden, kLogits);
    pool.run(kBatch, [&](size_t i, int) {
      const Choice c = choose(options.seed, trained.steps, static_cast<int>(i), taught);
      batch[i].run(net, taught[c.view], c, options.loss, back2, back3);
    });
    double loss = 0;
    for (const TileWork& work : batch) loss += work.loss / kBatch;
    adam.step(net, batch, schedule.rate(trained.steps));
    progress.step = ++trained.steps;
    progress.loss = progress.step == 1 ? loss : 0.98 * progress.loss + 0.02 * loss;
    if (trained.steps % kLook == 0 || trained.steps == schedule.end()) {
      trained.held_out = errors_of(net, kept, pool);
      progress.held_out = mean_of(trained.held_out);
      if (progress.held_out > (1 - kLeastGain) * before) schedule.end_soon(trained.steps);
      before = progress.held_out;
      progress.steps = schedule.end();
    }
    on_step(progress);
  }
  return trained;
}

}  // namespace qray
