#include "core/render/pixel_plan.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/math/hash.h"

namespace qray {
namespace {

constexpr float kLeastShare = 0.25f, kMostShare = 8;  // of the mean
constexpr int kRounds = 4;                            // to find the scale that uses all samples

}  // namespace

PixelPlan::PixelPlan(const RenderSettings& settings, bool in_rounds)
    : adaptive_(settings.pixels == Pixels::kByNoise),
      in_rounds_(in_rounds),
      seed_(settings.seed),
      step_(settings.pixels == Pixels::kAll ? 1 : 2),
      width_((settings.width + step_ - 1) / step_),
      height_((settings.height + step_ - 1) / step_) {
  QRAY_CHECK(!in_rounds || settings.pixels == Pixels::kAll);
}

void PixelPlan::start_pass(int samples, const NoiseEstimate* noise) {
  samples_ = static_cast<uint32_t>(samples);
  if (adaptive_ && noise && noise->known()) share_out(samples, *noise);
}

// What each should have in all, by its scatter, less what it had; the fraction by chance.
void PixelPlan::share_out(int samples, const NoiseEstimate& noise) {
  const size_t pixels = static_cast<size_t>(width_) * static_cast<size_t>(height_);
  if (counts_.empty()) done_each_.assign(pixels, done_);
  counts_.resize(pixels);
  std::vector<float> wanted(pixels);
  double sum = 0, had = 0;
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) sum += wanted[index(x, y)] = noise.relative_deviation(x, y);
  const float mean = std::max(static_cast<float>(sum / static_cast<double>(pixels)), 1e-6f);
  for (size_t i = 0; i < pixels; ++i) {
    wanted[i] = std::clamp(wanted[i] / mean, kLeastShare, kMostShare);
    had += done_each_[i];
  }
  // `scale`: samples in all, of a pixel that scatters as all do on average.
  const double spend = static_cast<double>(samples) * static_cast<double>(pixels);
  const auto lacks = [&](size_t i, float scale) {
    return std::max(0.0f, scale * wanted[i] - static_cast<float>(done_each_[i]));
  };
  float scale = static_cast<float>((had + spend) / static_cast<double>(pixels));
  for (int round = 0; round < kRounds; ++round) {
    double spent = 0, slope = 0;
    for (size_t i = 0; i < pixels; ++i) {
      const float n = lacks(i, scale);
      spent += n;
      if (n > 0) slope += wanted[i];
    }
    if (slope > 0) scale += static_cast<float>((spend - spent) / slope);
  }
  for (size_t i = 0; i < pixels; ++i) {
    const float n = lacks(i, scale);
    const uint64_t bits = mix64(mix64(seed_ ^ done_each_[i]) + i);
    counts_[i] = static_cast<uint32_t>(n + to_unit_float(static_cast<uint32_t>(bits >> 32)));
  }
}

void PixelPlan::end_pass() {
  done_ += samples_;
  for (size_t i = 0; i < counts_.size(); ++i) done_each_[i] += counts_[i];
}

}  // namespace qray
