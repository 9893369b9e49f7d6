#include "core/render/noise_estimate.h"

#include <algorithm>
#include <cmath>

#include "core/math/vec.h"

namespace qray {
namespace {

constexpr int kRadiusPx = 4;
constexpr float kKeep = 0.5f;          // of earlier passes, each pass: the guide gets better
constexpr float kDeviation = 1.2533f;  // over the mean absolute distance (of a normal variable),
                                       // which outliers move less than the mean square
constexpr double kTrimmed = 0.001;     // of the pixels: fireflies decide nothing

// Means over 2 kRadiusPx + 1 values along a line, fewer at its ends.
void blur_line(float* values, int count, size_t stride, std::vector<double>& sums) {
  sums.assign(static_cast<size_t>(count) + 1, 0);
  for (int i = 0; i < count; ++i)
    sums[static_cast<size_t>(i) + 1] =
        sums[static_cast<size_t>(i)] + static_cast<double>(values[static_cast<size_t>(i) * stride]);
  for (int i = 0; i < count; ++i) {
    const int lo = std::max(0, i - kRadiusPx), hi = std::min(count, i + kRadiusPx + 1);
    values[static_cast<size_t>(i) * stride] = static_cast<float>(
        (sums[static_cast<size_t>(hi)] - sums[static_cast<size_t>(lo)]) / (hi - lo));
  }
}

}  // namespace

NoiseEstimate::NoiseEstimate(int width, int height) : width_(width), height_(height) {
  const size_t pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
  for (auto* values : {&sum_, &half_[0], &half_[1], &square_}) values->resize(pixels);
}

void NoiseEstimate::start_pass(uint64_t first, int samples, bool guided) {
  if (guided != guided_) {
    for (int k = 0; k < 2; ++k) {
      std::fill(half_[k].begin(), half_[k].end(), 0.0f);
      count_[k] = 0;
    }
  }
  guided_ = guided;
  samples_ += samples;
  const int odd = (samples + static_cast<int>(first & 1)) / 2;
  count_[0] += samples - odd;
  count_[1] += odd;
}

void NoiseEstimate::add(int x, int y, float even, float odd) {
  const size_t i = index(x, y);
  half_[0][i] += even;
  half_[1][i] += odd;
  sum_[i] += even + odd;
}

bool NoiseEstimate::end_pass() {
  if (count_[0] == 0 || count_[1] == 0) return false;
  // The halves are independent: the variance of their difference is (1 / even + 1 / odd) times a
  // sample's.
  const float even = static_cast<float>(1 / count_[0]), odd = static_cast<float>(1 / count_[1]);
  const bool first = distance_.empty();
  if (!first) before_ = square_;
  distance_.resize(square_.size());
  for (size_t i = 0; i < square_.size(); ++i) {
    square_[i] = sqr(half_[0][i] * even - half_[1][i] * odd) / (even + odd);
    const float distance = std::sqrt(square_[i]);
    distance_[i] = first ? distance : lerp(kKeep, distance, distance_[i]);
  }
  for (int k = 0; k < 2; ++k) {
    std::fill(half_[k].begin(), half_[k].end(), 0.0f);
    count_[k] = 0;
  }
  deviation_ = distance_;
  for (float& d : deviation_) d *= kDeviation;
  blur(deviation_);
  std::vector<float> mean(sum_);
  for (float& m : mean) m *= static_cast<float>(1 / samples_);
  blur(mean);
  if (!guided_) {
    unguided_.resize(square_.size());
    const float part = static_cast<float>(1 / ++unguided_count_);
    for (size_t i = 0; i < square_.size(); ++i) unguided_[i] = lerp(part, unguided_[i], square_[i]);
  }
  variance_ = trimmed_mean(square_, mean);
  if (!first) variance_before_ = trimmed_mean(before_, mean);
  if (!unguided_.empty()) unguided_variance_ = trimmed_mean(unguided_, mean);
  return true;
}

double NoiseEstimate::trimmed_mean(const std::vector<float>& squares,
                                   const std::vector<float>& means) {
  std::vector<float> relative(squares.size());
  for (size_t i = 0; i < squares.size(); ++i) relative[i] = squares[i] / (sqr(means[i]) + 0.01f);
  const size_t kept =
      relative.size() - static_cast<size_t>(kTrimmed * static_cast<double>(relative.size()));
  std::nth_element(relative.begin(), relative.begin() + static_cast<std::ptrdiff_t>(kept - 1),
                   relative.end());
  double sum = 0;
  for (size_t i = 0; i < kept; ++i) sum += static_cast<double>(relative[i]);
  return sum / static_cast<double>(kept);
}

void NoiseEstimate::blur(std::vector<float>& values) const {
  std::vector<double> sums;
  const size_t width = static_cast<size_t>(width_), height = static_cast<size_t>(height_);
  for (size_t y = 0; y < height; ++y) blur_line(&values[y * width], width_, 1, sums);
  for (size_t x = 0; x < width; ++x) blur_line(&values[x], height_, width, sums);
}

}  // namespace qray
