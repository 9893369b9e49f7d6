#include "core/render/pixel_plan.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/math/hash.h"

namespace qray {
namespace {

// Of the spread. 1 would lower the sum of squared relative errors most, 2/3 the sum of relative
// errors; the spread itself is but an estimate.
constexpr float kPower = 0.7f;
constexpr float kLeastShare = 0.5f, kMostShare = 8;  // of the mean
constexpr uint32_t kFirstAlike = 16;  // samples a pixel: with fewer, the spread is not known
constexpr double kWorth = 1.1;        // less gain_of_shares() is not worth it
constexpr float kDark = 0.5f;         // of the median: the gain must not be at dark parts' cost
constexpr int kRounds = 4;            // to find the scale that uses all samples
constexpr uint64_t kMostAhead = 16;   // as often as all is the region sampled in a pass: workers
                                      // stop between pixels

// What part of the mean number of samples each pixel should get.
std::vector<float> shares_of(const std::vector<float>& spread) {
  std::vector<float> shares(spread.size());
  double sum = 0;
  for (size_t i = 0; i < spread.size(); ++i) sum += shares[i] = std::pow(spread[i], kPower);
  const float mean = std::max(static_cast<float>(sum / static_cast<double>(shares.size())), 1e-6f);
  for (float& share : shares) share = std::clamp(share / mean, kLeastShare, kMostShare);
  return shares;
}

// Samples of a pixel whose share is 1, where none gets less than one and all have `samples` on
// average.
float scale_of(const std::vector<float>& shares, int samples) {
  const double spend = static_cast<double>(samples) * static_cast<double>(shares.size());
  auto scale = static_cast<float>(samples);
  for (int round = 0; round < kRounds; ++round) {
    double spent = 0, slope = 0;
    for (const float share : shares) {
      spent += std::max(1.0f, scale * share);
      if (scale * share > 1) slope += share;
    }
    if (slope > 0) scale += static_cast<float>((spend - spent) / slope);
  }
  return scale;
}

// The relative variance of a pass in which all pixels have `samples`, over that of one in which
// they have their shares.
double gain_of_shares(const std::vector<float>& spread, const std::vector<float>& shares,
                      float scale, int samples) {
  double alike = 0, shared = 0;
  for (size_t i = 0; i < spread.size(); ++i) {
    const auto variance = static_cast<double>(sqr(spread[i]));
    alike += variance / samples;
    shared += variance / static_cast<double>(std::max(1.0f, scale * shares[i]));
  }
  return shared > 0 ? alike / shared : 1;
}

}  // namespace

PixelPlan::PixelPlan(const RenderSettings& settings, bool in_rounds)
    : by_noise_(!in_rounds && settings.counts_by_noise()),
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
  if (by_noise_ && noise && noise->known() && done_ >= kFirstAlike) share_out(samples, *noise);
}

// By the spread about each pixel; the fraction by chance.
void PixelPlan::share_out(int samples, const NoiseEstimate& noise) {
  const std::vector<float> spread = noise.spread(), shares = shares_of(spread);
  const float scale = scale_of(shares, samples);
  const bool pays = gain_of_shares(noise.spread(kDark), shares, scale, samples) > kWorth;
  if (counts_.empty() && pays) {
    done_each_.assign(spread.size(), done_);
    counts_.resize(spread.size());
  }
  for (size_t i = 0; i < counts_.size(); ++i) {
    const uint64_t bits = mix64(mix64(seed_ ^ done_each_[i]) + i);
    const float n = scale * shares[i] + to_unit_float(static_cast<uint32_t>(bits >> 32));
    counts_[i] = static_cast<uint32_t>(pays ? std::max(1.0f, n) : static_cast<float>(samples));
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
