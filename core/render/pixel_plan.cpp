#include "core/render/pixel_plan.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/math/hash.h"

namespace qray {
namespace {

constexpr float kLeastShare = 0.25f, kMostShare = 8;  // of the mean
constexpr int kRounds = 4;                            // to find the scale that uses all samples
constexpr uint64_t kMostAhead = 16;  // as often as all is the region sampled in a pass: workers
                                     // stop between pixels

}  // namespace

PixelPlan::PixelPlan(const RenderSettings& settings, bool in_rounds)
    : adaptive_(settings.pixels == Pixels::kByNoise),
      in_rounds_(in_rounds),
      seed_(settings.seed),
      step_(settings.pixels == Pixels::kAll ? 1 : 2),
      width_((settings.width + step_ - 1) / step_),
      height_((settings.height + step_ - 1) / step_),
      region_(region_of(settings, step_)),
      most_(settings.seconds > 0 || settings.noise > 0 ? 0
                                                       : static_cast<uint32_t>(settings.samples)) {
  QRAY_CHECK(!in_rounds || settings.pixels == Pixels::kAll);
}

PixelPlan::Region PixelPlan::region_of(const RenderSettings& settings, int step) {
  const auto first_from = [step](int pixel) { return (pixel + step - 1) / step; };
  const PixelRegion& of = settings.region;
  return {first_from(of.x), first_from(of.y), first_from(of.x + of.width),
          first_from(of.y + of.height)};
}

void PixelPlan::start_pass(int samples, const NoiseEstimate* noise) {
  samples_ = in_region_ = static_cast<uint32_t>(samples);
  // The first pass shows something everywhere.
  if (done_ > 0 && region_.pixels() > 0 && region_.pixels() < pixels()) prefer_region();
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

// All of the pass, until the region has the render's samples; half of it where these are not known.
void PixelPlan::prefer_region() {
  const uint64_t inside = region_.pixels(), outside = pixels() - inside;
  const uint64_t spend = spare_ + samples_ * pixels();
  const uint64_t lacks = most_ > done_in_region_ ? most_ - done_in_region_ : 0;
  const uint64_t wanted = most_ > 0 ? std::min(spend / inside, lacks)
                                    : std::max<uint64_t>(spend / 2 / inside, samples_);
  in_region_ = static_cast<uint32_t>(std::min(wanted, kMostAhead * samples_));
  const uint64_t left = spend - in_region_ * inside;
  samples_ = static_cast<uint32_t>(left / outside);
  spare_ = left % outside;
}

void PixelPlan::end_pass() {
  done_ += samples_;
  done_in_region_ += in_region_;
  for (size_t i = 0; i < counts_.size(); ++i) done_each_[i] += counts_[i];
}

}  // namespace qray
