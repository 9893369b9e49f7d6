#include "core/recover/train.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/base/check.h"
#include "core/image/metrics.h"
#include "core/math/hash.h"
#include "core/recover/loss.h"
#include "core/recover/pyramid_pass.h"

namespace qray {
namespace {

constexpr int kBatch = 8;
constexpr int kTileBlocks = 48;  // a side
constexpr float kRate = 2e-3f, kBeta1 = 0.9f, kBeta2 = 0.99f, kLastRate = 0.02f;
constexpr float kScalesRate = 6;  // times the rate
constexpr float kKeep = 0.998f;   // of the moving mean of the values, by each step
constexpr int kWarmUp = 20;       // steps
constexpr double kMostGradient = 1;
constexpr double kLeastLoss = 1e-3;  // of a tile, as it is weighted
constexpr int kLook = 200;           // steps between looks at the views kept apart

struct Choice {
  size_t view;
  int y, x;
  Flip flip;
  uint32_t exchange;  // of channels and axes
};

// A batch's tiles, from the seed and the step alone.
Choice choose(uint64_t seed, int step, int tile, std::span<const TrainingView> views) {
  uint64_t bits = mix64(mix64(seed) + static_cast<uint64_t>(step * kBatch + tile));
  const auto below = [&](int n) {
    bits = mix64(bits + 1);
    return static_cast<int>(bits >> 33) % n;
  };
  Choice c{static_cast<size_t>(below(static_cast<int>(views.size()))), 0, 0, {}, 0};
  const int room = std::max(1, views[c.view].input.features.width() / 2 - kTileBlocks + 1);
  c.y = below(room), c.x = below(room);
  const int flip = below(8);
  c.flip = {(flip & 1) != 0, (flip & 2) != 0, (flip & 4) != 0};
  c.exchange = static_cast<uint32_t>(below(6 * 6 * 8));
  return c;
}

// Colours of other lamps and paints, in a world that stands otherwise: which of 6 * 6 * 8.
void exchange_channels(RecoveryInput& input, Image& target, uint32_t which) {
  constexpr int kOrders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  const int* colours = kOrders[which % 6];
  const int* axes = kOrders[which / 6 % 6];
  const uint32_t mirrored = which / 36;
  const auto exchange = [](Image& image, int first, const int* order, uint32_t negative) {
    for (int y = 0; y < image.height(); ++y)
      for (int x = 0; x < image.width(); ++x) {
        const float was[3] = {image.at(x, y, first), image.at(x, y, first + 1),
                              image.at(x, y, first + 2)};
        for (int k = 0; k < 3; ++k)
          image.at(x, y, first + k) = (negative >> k & 1) != 0 ? -was[order[k]] : was[order[k]];
      }
  };
  for (Image* image : {&input.features, &input.colour, &input.shown, &target})
    exchange(*image, 0, colours, 0);
  exchange(input.features, kFeatureNormal, axes, mirrored);
}

// The loss of a batch's tile; adds the gradient of its logarithm: a dark noisy view counts no more
// than a clean one.
double learn_tile(PyramidPass& pass, std::span<const float> values, const TrainingView& view,
                  const Choice& c, std::span<float> gradient) {
  const auto part = [&](const Image& image) {
    const int side = std::min(2 * kTileBlocks, image.width());
    return turned(image, 2 * c.y, 2 * c.x, side, side, c.flip);
  };
  RecoveryInput input{part(view.input.features), part(view.input.colour), part(view.input.noise),
                      part(view.input.own_error), part(view.input.shown)};
  Image target = part(view.target);
  exchange_channels(input, target, c.exchange);
  // Errors count as they are seen in a picture of usual brightness.
  const float exposure = exposure_of(view.input.colour);
  Image albedo(target.width(), target.height(), kColour);
  for (int y = 0; y < target.height(); ++y)
    for (int x = 0; x < target.width(); ++x)
      for (int k = 0; k < kColour; ++k) {
        albedo.at(x, y, k) = exposure * (input.features.at(x, y, k) + kAlbedoFloor);
        target.at(x, y, k) *= exposure;
      }
  const Image result = pass.forward(values, {input, exposure}, nullptr, true);
  std::vector<float> d_result;
  const double loss = log_loss(result, albedo, target, d_result);
  for (float& d : d_result) d /= static_cast<float>(loss + kLeastLoss);
  pass.backward(values, d_result, gradient);
  return loss;
}

class Adam {
 public:
  explicit Adam(size_t size) : first_(size), second_(size) {}

  // The mean of the batch's gradients, shortened to kMostGradient.
  void step(std::vector<float>& values, std::span<std::vector<float>> batch, float rate) {
    std::vector<float>& mean = batch[0];
    double square = 0;
    for (size_t i = 0; i < mean.size(); ++i) {
      for (size_t k = 1; k < batch.size(); ++k) mean[i] += batch[k][i];
      mean[i] /= static_cast<float>(batch.size());
      square += static_cast<double>(mean[i]) * static_cast<double>(mean[i]);
    }
    const float shorten =
        static_cast<float>(std::min(1.0, kMostGradient / std::sqrt(square + 1e-20)));
    power1_ *= kBeta1, power2_ *= kBeta2;
    for (size_t i = 0; i < mean.size(); ++i) {
      const float g = mean[i] * shorten;
      first_[i] = kBeta1 * first_[i] + (1 - kBeta1) * g;
      second_[i] = kBeta2 * second_[i] + (1 - kBeta2) * g * g;
      values[i] -= (i >= pyramid_scales() ? kScalesRate * rate : rate) *
                   (first_[i] / (1 - power1_)) / (std::sqrt(second_[i] / (1 - power2_)) + 1e-8f);
    }
  }

 private:
  std::vector<float> first_, second_;
  float power1_ = 1, power2_ = 1;
};

// Rises at first, and falls along a cosine to kLastRate of its height.
float rate_at(int step, int steps) {
  const float part = static_cast<float>(step) / static_cast<float>(steps);
  const float height = 0.5f * (1 - kLastRate) * (1 + std::cos(std::numbers::pi_v<float> * part));
  return kRate * std::min(1.0f, static_cast<float>(step + 1) / kWarmUp) * (height + kLastRate);
}

std::vector<double> errors_of(const Network& net, std::span<const TrainingView> views,
                              TaskPool& pool) {
  std::vector<double> errors(views.size());
  pool.run(views.size(), [&](size_t i, int) { errors[i] = cleaning_error(net, views[i]); });
  return errors;
}

double mean_of(const std::vector<double>& v) {
  return std::accumulate(v.begin(), v.end(), 0.0) / static_cast<double>(v.size());
}

}  // namespace

double picture_error(const Image& picture, const TrainingView& view) {
  return relmse(picture, view.target) - view.target_relmse;
}

double cleaning_error(const Network& net, const TrainingView& view) {
  PyramidPass pass;
  return picture_error(
      pass.recover(net.values, {view.input, exposure_of(view.input.colour)}, nullptr), view);
}

Result<Trained> train(Network start, std::span<const TrainingView> views, size_t held_out,
                      const TrainOptions& options, TaskPool& pool, std::stop_token stop,
                      const std::function<void(const TrainProgress&)>& on_step) {
  QRAY_CHECK(held_out >= 1 && views.size() > held_out);
  const std::span<const TrainingView> taught = views.first(views.size() - held_out);
  const std::span<const TrainingView> kept = views.last(held_out);
  std::vector<float> values = start.values;
  std::vector<double> errors = errors_of(start, kept, pool);
  Trained result{std::move(start), std::move(errors)};
  Adam adam(values.size());
  std::vector<PyramidPass> passes(kBatch);
  std::vector<std::vector<float>> gradients(kBatch);
  std::vector<double> losses(kBatch);
  TrainProgress progress{.held_out = mean_of(result.held_out)};
  for (int step = 0; step < options.steps; ++step) {
    if (stop.stop_requested()) return Error{ErrorCode::kCanceled, "canceled", ""};
    pool.run(kBatch, [&](size_t i, int) {
      gradients[i].assign(values.size(), 0);
      const Choice c = choose(options.seed, step, static_cast<int>(i), taught);
      losses[i] = learn_tile(passes[i], values, taught[c.view], c, gradients[i]);
    });
    const double loss = mean_of(losses);
    adam.step(values, gradients, rate_at(step, options.steps));
    // From the start on, a mean of as many steps as there were.
    const float keep = std::min(kKeep, static_cast<float>(step) / static_cast<float>(step + 9));
    std::vector<float>& mean = result.network.values;
    for (size_t i = 0; i < values.size(); ++i) mean[i] = lerp(keep, values[i], mean[i]);
    progress.step = step + 1;
    progress.loss = step == 0 ? loss : 0.98 * progress.loss + 0.02 * loss;
    if (progress.step % kLook == 0 || progress.step == options.steps) {
      result.held_out = errors_of(result.network, kept, pool);
      progress.values = mean;
      progress.held_out = mean_of(result.held_out);
    }
    on_step(progress);
    progress.values = {};
  }
  return result;
}

}  // namespace qray
