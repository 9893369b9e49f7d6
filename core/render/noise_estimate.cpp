#include "core/render/noise_estimate.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/math/vec.h"

namespace qray {
namespace {

constexpr int kRadiusPx = 4, kNearPx = 2;
constexpr float kKeep = 0.5f;  // of earlier passes, each pass: the guide gets better
constexpr float kOverMeanDistance =
    1.2533f;                        // over the mean absolute distance (of a normal variable),
                                    // which outliers move less than the mean square
constexpr double kTrimmed = 0.001;  // of the pixels: fireflies decide nothing
// What counts beside a mean: of the variance a part of the picture's median, so that the unit of
// light changes nothing; of errors, as of relMSE, a luminance.
constexpr float kDark = 0.5f, kErrorFloor = 0.1f;
constexpr double kMostFade = 16;  // at once: a noisy estimate must not undo a picture

// Means over 2 radius + 1 values along a line, fewer at its ends.
void blur_line(float* values, int count, size_t stride, int radius, std::vector<double>& sums) {
  sums.assign(static_cast<size_t>(count) + 1, 0);
  for (int i = 0; i < count; ++i)
    sums[static_cast<size_t>(i) + 1] =
        sums[static_cast<size_t>(i)] + static_cast<double>(values[static_cast<size_t>(i) * stride]);
  for (int i = 0; i < count; ++i) {
    const int lo = std::max(0, i - radius), hi = std::min(count, i + radius + 1);
    values[static_cast<size_t>(i) * stride] = static_cast<float>(
        (sums[static_cast<size_t>(hi)] - sums[static_cast<size_t>(lo)]) / (hi - lo));
  }
}

// 0: none is lit.
float median_of_lit(std::vector<float> values) {
  std::erase_if(values, [](float v) { return !(v > 0); });
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

NoiseEstimate::NoiseEstimate(int width, int height) : width_(width), height_(height) {
  const size_t pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
  for (int odd : {0, 1})
    for (auto* values : {&all_[odd], &all_count_[odd], &half_[odd], &count_[odd]})
      values->resize(pixels);
  saved_.resize(pixels);
  guided_samples_.resize(pixels);
  square_.resize(pixels);
  mean_.resize(pixels);
}

void NoiseEstimate::start_pass(bool guided, bool learning) {
  if (guided != guided_ || learning != learning_)
    for_each_sum([](std::vector<float>& sums) { std::fill(sums.begin(), sums.end(), 0.0f); });
  guided_ = guided;
  learning_ = learning;
}

void NoiseEstimate::add(int x, int y, uint32_t first, uint32_t count,
                        const SampleHalves<float>& sums, std::optional<double> saved) {
  const size_t i = index(x, y);
  const auto evens = static_cast<float>(TileSamples::even_count(first, count));
  if (saved) {
    saved_[i] += static_cast<float>(*saved);
    guided_samples_[i] += static_cast<float>(count);
  }
  half_[0][i] += sums.even;
  half_[1][i] += sums.odd;
  all_[0][i] += sums.earlier;
  all_[1][i] += sums.later;
  for (auto* counts : {&count_, &all_count_}) {
    (*counts)[0][i] += evens;
    (*counts)[1][i] += static_cast<float>(count) - evens;
  }
}

bool NoiseEstimate::end_pass() {
  const bool first = distance_.empty();
  const auto ready = [this](size_t i) { return count_[0][i] > 0 && count_[1][i] > 0; };
  bool any = false;
  for (size_t i = 0; i < square_.size() && !any; ++i) any = ready(i);
  if (!any) return false;
  if (!first) before_ = square_;
  distance_.resize(square_.size());
  std::vector<size_t> guided;  // pixels
  std::vector<float> saved;    // a sample of theirs, on average
  for (size_t i = 0; i < square_.size(); ++i) {
    if (!ready(i)) continue;
    // The halves are independent: the variance of their difference is (1 / even + 1 / odd) times a
    // sample's.
    const float even = 1 / count_[0][i], odd = 1 / count_[1][i];
    square_[i] = sqr(half_[0][i] * even - half_[1][i] * odd) / (even + odd);
    const float distance = std::sqrt(square_[i]);
    distance_[i] = first ? distance : lerp(kKeep, distance, distance_[i]);
    if (guided_ && guided_samples_[i] > 0) {
      guided.push_back(i);
      saved.push_back(saved_[i] / guided_samples_[i]);
    }
    for_each_sum([i](std::vector<float>& sums) { sums[i] = 0; });
  }
  deviation_ = distance_;
  for (float& d : deviation_) d *= kOverMeanDistance;
  blur(deviation_, kRadiusPx);
  mean_ = means();
  blur(mean_, kRadiusPx);
  const float floor = kDark * median_of_lit(mean_);
  variance_ = trimmed_mean(square_, mean_, floor);
  if (!first) variance_before_ = trimmed_mean(before_, mean_, floor);
  guided_variance_ = unguided_variance_ = 0;
  if (guided.empty()) return true;
  std::vector<float> with(guided.size()), without(guided.size()), means(guided.size());
  for (size_t n = 0; n < guided.size(); ++n) {
    with[n] = square_[guided[n]];
    without[n] = with[n] + saved[n];
    means[n] = mean_[guided[n]];
  }
  guided_variance_ = trimmed_mean(with, means, floor);
  if (learning_) unguided_variance_ = trimmed_mean(without, means, floor);
  return true;
}

float NoiseEstimate::weight_of_earlier() const {
  if (!(variance_ > 0) || !(variance_before_ > 0)) return 1;
  return static_cast<float>(std::clamp(variance_ / variance_before_, 1 / kMostFade, 1.0));
}

std::vector<float> NoiseEstimate::means() const {
  std::vector<float> means(mean_.size());
  for (size_t i = 0; i < means.size(); ++i) {
    const float samples = all_count_[0][i] + all_count_[1][i];
    means[i] = samples > 0 ? (all_[0][i] + all_[1][i]) * (1 / samples) : 0.0f;
  }
  return means;
}

std::vector<float> NoiseEstimate::spread(float dark) const {
  std::vector<float> near = means(), spread = distance_;
  blur(near, kNearPx);
  blur(spread, kNearPx);
  const float floor = dark * median_of_lit(near);
  for (size_t i = 0; i < spread.size(); ++i) {
    const float like = std::sqrt(sqr(near[i]) + sqr(floor));
    spread[i] = like > 0 ? spread[i] * kOverMeanDistance / like : 0.0f;
  }
  return spread;
}

float NoiseEstimate::relative_error(int x, int y) const {
  const float samples = this->samples(x, y);
  if (!known() || !(samples > 0)) return kMostError;
  const size_t i = index(x, y);
  return std::min(deviation_[i] / (mean_[i] + 1e-3f), kMostError) / std::sqrt(samples);
}

float NoiseEstimate::own_error(int x, int y) const {
  const size_t i = index(x, y);
  const float earlier = all_count_[0][i], later = all_count_[1][i];
  if (earlier == 0 || later == 0) return std::numeric_limits<float>::infinity();
  // The halves' distance has the variance (1 / earlier + 1 / later) of a sample, the mean 1 /
  // samples.
  return std::abs(all_[0][i] / earlier - all_[1][i] / later) * std::sqrt(earlier * later) /
         (earlier + later);
}

double NoiseEstimate::level() const {
  if (!known()) return 0;
  std::vector<float> squares(mean_.size());
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) {
      const float error = own_error(x, y);
      squares[index(x, y)] = std::isfinite(error) ? sqr(error) : 0.0f;
    }
  return std::sqrt(trimmed_mean(squares, mean_, kErrorFloor));
}

double NoiseEstimate::trimmed_mean(const std::vector<float>& squares,
                                   const std::vector<float>& means, float floor) {
  std::vector<float> relative(squares.size());
  for (size_t i = 0; i < squares.size(); ++i) {
    const float like = sqr(means[i]) + sqr(floor);
    relative[i] = like > 0 ? squares[i] / like : 0.0f;
  }
  const size_t kept =
      relative.size() - static_cast<size_t>(kTrimmed * static_cast<double>(relative.size()));
  std::nth_element(relative.begin(), relative.begin() + static_cast<std::ptrdiff_t>(kept - 1),
                   relative.end());
  double sum = 0;
  for (size_t i = 0; i < kept; ++i) sum += static_cast<double>(relative[i]);
  return sum / static_cast<double>(kept);
}

void NoiseEstimate::blur(std::vector<float>& values, int radius) const {
  std::vector<double> sums;
  const size_t width = static_cast<size_t>(width_), height = static_cast<size_t>(height_);
  for (size_t y = 0; y < height; ++y) blur_line(&values[y * width], width_, 1, radius, sums);
  for (size_t x = 0; x < width; ++x) blur_line(&values[x], height_, width, radius, sums);
}

}  // namespace qray
