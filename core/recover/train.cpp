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
#include "core/recover/tile_pass.h"

namespace qray {
namespace {

constexpr int kBatch = 8;
constexpr int kTileBlocks = 32;         // a side
constexpr int kPyramidTileBlocks = 48;  // of a larger reach
constexpr float kRate = 3e-3f, kPyramidRate = 2e-3f, kBeta1 = 0.9f, kBeta2 = 0.99f,
                kLastRate = 0.02f;
constexpr float kScalesRate = 6;  // times the rate
constexpr float kKeep = 0.998f;   // of the moving mean of the pyramid's values, by each step
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
  uint32_t exchange;  // of channels and axes
};

// A batch's tiles, from the seed and the step alone.
Choice choose(uint64_t seed, int step, int tile, int blocks, std::span<const TrainingView> views) {
  uint64_t bits = mix64(mix64(seed) + static_cast<uint64_t>(step * kBatch + tile));
  const auto below = [&](int n) {
    bits = mix64(bits + 1);
    return static_cast<int>(bits >> 33) % n;
  };
  Choice c{static_cast<size_t>(below(static_cast<int>(views.size()))), 0, 0, {}, 0};
  const int room = std::max(1, views[c.view].input.features.width() / 2 - blocks + 1);
  c.y = below(room), c.x = below(room);
  const int flip = below(8);
  c.flip = {(flip & 1) != 0, (flip & 2) != 0, (flip & 4) != 0};
  c.exchange = static_cast<uint32_t>(below(6 * 6 * 8));
  return c;
}

using Values = std::span<const float>;

// A network that is taught.
class Pupil {
 public:
  virtual ~Pupil() = default;
  virtual int tile_blocks() const = 0;
  virtual size_t scales() const = 0;  // where they begin in the values
  virtual float rate() const = 0;
  virtual int fall(int steps) const = 0;  // of the rate: over how many of the last steps
  virtual bool may_stop_early() const = 0;
  virtual bool gives_mean() const = 0;  // of its last values, rather than the last
  virtual void begin_step(Values) {}
  // The loss of a batch's tile; adds the gradient of its logarithm: a dark noisy view counts no
  // more than a clean one. Tiles are run by several threads.
  virtual double run(size_t tile, Values values, const TrainingView& view, const Choice& c,
                     std::span<float> gradient) = 0;
  virtual double error(Values values, const TrainingView& view) const = 0;
};

void of_logarithm(std::vector<float>& d_result, double loss) {
  for (float& d : d_result) d /= static_cast<float>(loss + kLeastLoss);
}

class BlockPupil final : public Pupil {
 public:
  explicit BlockPupil(int hidden) : shape_{hidden, {}}, passes_(kBatch) {}
  int tile_blocks() const override { return kTileBlocks; }
  size_t scales() const override { return shape_.parts().scales; }
  float rate() const override { return kRate; }
  int fall(int) const override { return kLook; }
  bool may_stop_early() const override { return true; }
  bool gives_mean() const override { return false; }

  void begin_step(Values values) override {
    const Network::Parts at = shape_.parts();
    net_ = network(values);
    back2_ = transposed(&values[at.weights2], kTaps, shape_.hidden, shape_.hidden);
    back3_ = transposed(&values[at.weights3], 1, shape_.hidden, kLogits);
  }
  double run(size_t i, Values, const TrainingView& view, const Choice& c,
             std::span<float> gradient) override {
    const BlockTile tile = tile_of(view.input.features, view.input.colour, view.input.noise, c.y,
                                   c.x, kTileBlocks, kTileBlocks, c.flip);
    const std::vector<float> target = target_of(view, c.y, c.x, kTileBlocks, kTileBlocks, c.flip);
    std::vector<float> d_result;
    const double loss =
        relative_squared_loss(passes_[i].forward(net_, tile), tile.albedo, target, d_result);
    of_logarithm(d_result, loss);
    passes_[i].backward(net_, tile, d_result, back2_, back3_, gradient);
    return loss;
  }
  double error(Values values, const TrainingView& view) const override {
    return recovery_error(network(values), view);
  }

 private:
  Network network(Values values) const { return {shape_.hidden, {values.begin(), values.end()}}; }

  Network shape_, net_;
  std::vector<float> back2_, back3_;
  std::vector<TilePass> passes_;
};

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

class PyramidPupil final : public Pupil {
 public:
  PyramidPupil() : passes_(kBatch) {}
  int tile_blocks() const override { return kPyramidTileBlocks; }
  size_t scales() const override { return pyramid_scales(); }
  float rate() const override { return kPyramidRate; }
  int fall(int steps) const override { return steps; }
  bool may_stop_early() const override { return false; }
  bool gives_mean() const override { return true; }

  double run(size_t i, Values values, const TrainingView& view, const Choice& c,
             std::span<float> gradient) override {
    const auto part = [&](const Image& image) {
      const int side = std::min(2 * kPyramidTileBlocks, image.width());
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
    const Image result = passes_[i].forward(values, {input, exposure}, nullptr, true);
    std::vector<float> d_result;
    const double loss = log_loss(result, albedo, target, d_result);
    of_logarithm(d_result, loss);
    passes_[i].backward(values, d_result, gradient);
    return loss;
  }
  double error(Values values, const TrainingView& view) const override {
    return pyramid_error(values, view);
  }

 private:
  std::vector<PyramidPass> passes_;
};

class Adam {
 public:
  explicit Adam(size_t size) : first_(size), second_(size) {}

  // The mean of the batch's gradients, shortened to kMostGradient.
  void step(std::vector<float>& values, size_t scales, std::span<std::vector<float>> batch,
            float rate) {
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
      values[i] -= (i >= scales ? kScalesRate * rate : rate) * (first_[i] / (1 - power1_)) /
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
  Schedule(int steps, float height, int fall)
      : height_(height), end_(steps), fall_(std::max(0, steps - fall)) {}

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
    return height_ * std::min(1.0f, static_cast<float>(step + 1) / kWarmUp) * (height + kLastRate);
  }

 private:
  float height_;
  int end_, fall_;
};

std::vector<double> errors_of(const Pupil& pupil, Values values,
                              std::span<const TrainingView> views, TaskPool& pool) {
  std::vector<double> errors(views.size());
  pool.run(views.size(), [&](size_t i, int) { errors[i] = pupil.error(values, views[i]); });
  return errors;
}

double mean_of(const std::vector<double>& v) {
  return std::accumulate(v.begin(), v.end(), 0.0) / static_cast<double>(v.size());
}

struct Taught {
  std::vector<float> values;
  int steps = 0;
  std::vector<double> held_out;
};

Result<Taught> teach(Pupil& pupil, std::vector<float> start, std::span<const TrainingView> views,
                     size_t held_out, const TrainOptions& options, TaskPool& pool,
                     std::stop_token stop,
                     const std::function<void(const TrainProgress&)>& on_step) {
  QRAY_CHECK(held_out >= 1 && views.size() > held_out);
  const std::span<const TrainingView> taught = views.first(views.size() - held_out);
  const std::span<const TrainingView> kept = views.last(held_out);
  Taught result{std::move(start), 0, {}};
  std::vector<float> values = result.values;  // result.values: what is given
  Adam adam(values.size());
  std::vector<std::vector<float>> gradients(kBatch);
  std::vector<double> losses(kBatch);
  Schedule schedule(options.steps, pupil.rate(), pupil.fall(options.steps));
  TrainProgress progress{0, options.steps, 0, 0};
  result.held_out = errors_of(pupil, result.values, kept, pool);
  double before = progress.held_out = mean_of(result.held_out);
  while (result.steps < schedule.end()) {
    if (stop.stop_requested()) return Error{ErrorCode::kCanceled, "canceled", ""};
    pupil.begin_step(values);
    pool.run(kBatch, [&](size_t i, int) {
      gradients[i].assign(values.size(), 0);
      const Choice c =
          choose(options.seed, result.steps, static_cast<int>(i), pupil.tile_blocks(), taught);
      losses[i] = pupil.run(i, values, taught[c.view], c, gradients[i]);
    });
    const double loss = mean_of(losses);
    adam.step(values, pupil.scales(), gradients, schedule.rate(result.steps));
    // From the start on, a mean of as many steps as there were.
    const float keep = !pupil.gives_mean()
                           ? 0
                           : std::min(kKeep, static_cast<float>(result.steps) /
                                                 static_cast<float>(result.steps + 9));
    for (size_t i = 0; i < values.size(); ++i)
      result.values[i] = lerp(keep, values[i], result.values[i]);
    progress.step = ++result.steps;
    progress.loss = progress.step == 1 ? loss : 0.98 * progress.loss + 0.02 * loss;
    if (result.steps % kLook == 0 || result.steps == schedule.end()) {
      result.held_out = errors_of(pupil, result.values, kept, pool);
      progress.values = result.values;
      progress.held_out = mean_of(result.held_out);
      if (pupil.may_stop_early() && progress.held_out > (1 - kLeastGain) * before)
        schedule.end_soon(result.steps);
      before = progress.held_out;
      progress.steps = schedule.end();
    }
    on_step(progress);
    progress.values = {};
  }
  return result;
}

}  // namespace

double picture_error(const Image& picture, const TrainingView& view) {
  return relmse(picture, view.target) - view.target_relmse;
}

double recovery_error(const Network& net, const TrainingView& view) {
  const int height = view.input.features.height() / 2, width = view.input.features.width() / 2;
  const BlockTile tile =
      tile_of(view.input.features, view.input.colour, view.input.noise, 0, 0, height, width);
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

double pyramid_error(std::span<const float> values, const TrainingView& view) {
  PyramidPass pass;
  const Image picture = pass.recover(values, {view.input, exposure_of(view.input.colour)}, nullptr);
  return picture_error(picture, view);
}

Result<Trained> train(Network start, std::span<const TrainingView> views, size_t held_out,
                      const TrainOptions& options, TaskPool& pool, std::stop_token stop,
                      const std::function<void(const TrainProgress&)>& on_step) {
  BlockPupil pupil(start.hidden);
  Result<Taught> taught = teach(pupil, std::move(start.values), views, held_out, options, pool,
                                std::move(stop), on_step);
  if (!taught) return taught.error();
  Taught& t = taught.value();
  return Trained{{start.hidden, std::move(t.values)}, t.steps, std::move(t.held_out)};
}

Result<TrainedPyramid> train_pyramid(std::vector<float> start, std::span<const TrainingView> views,
                                     size_t held_out, const TrainOptions& options, TaskPool& pool,
                                     std::stop_token stop,
                                     const std::function<void(const TrainProgress&)>& on_step) {
  PyramidPupil pupil;
  Result<Taught> taught =
      teach(pupil, std::move(start), views, held_out, options, pool, std::move(stop), on_step);
  if (!taught) return taught.error();
  Taught& t = taught.value();
  return TrainedPyramid{std::move(t.values), t.steps, std::move(t.held_out)};
}

}  // namespace qray
