#include "core/render/guide_gate.h"

#include <algorithm>

namespace qray {
namespace {

// A guide that gains less is left, once a pixel has so many samples and its table has seen
// kLeastEvents: in a small picture it takes more samples to learn as much. A young table need only
// be near to paying. An old one must gain more than 1: Sobol points help the BSDF's smooth
// densities more than the guide's, by up to 1.4, which no path tells.
struct Least {
  uint64_t samples;
  double gain;
};
constexpr Least kYoung{8, 0.9}, kOld{16, 1.25};
constexpr uint64_t kLeastEvents = 1'000'000;
constexpr uint64_t kOldEvents = 4'000'000;  // a table that saw so many is old at once
constexpr uint64_t kWarm = 4;  // samples: a guide that starts from a table is old by then
constexpr double kHope = 1.1;  // a loser that got better by this goes on
// A sample's variance from which a picture has much noise; and below which it surely has little.
// Between them rare light may not have shown yet, so that a pilot looks at more samples. What a
// guide must gain on a part to serve all of a picture that has little noise, whose Sobol points
// matter most.
constexpr double kMuchNoise = 2.5, kLittleNoise = 1, kPartGain = 2;
constexpr uint64_t kSureSamples = 4;  // a pixel
// What learning as much again must have brought: for an old table to grow on, of two checks in a
// row one, since gains are noisy; for learning to go on.
constexpr double kLeastGrowth = 1.25, kLeastGain = 1.1;
constexpr uint64_t kFirstEnd = 32;  // samples: learning goes on at least as long

}  // namespace

GuideGate::GuideGate(double lookup_rays, bool warm, bool open, const GuideWorth& worth)
    : lookup_rays_(lookup_rays),
      warm_(warm),
      open_(open),
      trusted_(paid(worth)),
      lost_(worth.efficiency_gain > 0 && worth.efficiency_gain < kYoung.gain) {
  if (trusted_) unguided_cost_ = worth.unguided_cost;
}

bool GuideGate::paid(const GuideWorth& worth) {
  return worth.efficiency_gain >= kOld.gain && worth.unguided_cost > 0;
}

bool GuideGate::noisy() const { return variance_ == 0 || variance_ >= kMuchNoise; }

bool GuideGate::pilot_is_over(uint64_t samples, uint64_t table_samples_seen) const {
  if (!knows_noise(samples)) return false;
  if (!noisy()) return variance_ < kLittleNoise || samples >= kSureSamples;
  return samples >= kMostPilotSamples || knows_enough(table_samples_seen);
}

GuideGate GuideGate::after_pilot() const {
  GuideGate gate(lookup_rays_);
  gate.warm_ = warm_;
  gate.open_ = open_;
  gate.trusted_ = true;
  gate.lost_ = lost_;
  gate.variance_ = variance_;
  gate.part_ = lost_ || !noisy();
  if (gate.part_) gate.start_ = lost_ && !noisy() ? kLatestStart : kLateStart;
  gate.unguided_ = unguided_;
  return gate;
}

void GuideGate::unguided(const PassCost& cost, double variance) {
  unguided_.paths += cost.paths;
  unguided_.rays += cost.rays;
  if (!(variance > 0)) return;
  const bool was_noisy = noisy();
  variance_ = std::max(variance_, variance);
  if (noisy() && !was_noisy && !lost_) {  // fewer samples did not show it
    part_ = false;
    start_ = 0;
  }
  if (!noisy() && !trusted_ && checks_.empty()) {
    part_ = true;
    start_ = kLateStart;
  }
}

double GuideGate::guided(uint64_t samples, uint64_t table_samples_seen, const PassCost& cost,
                         double variance, double unguided_variance) {
  if (!(cost.paths > 0) || !(variance > 0)) return 0;
  if (unguided_.paths > 0) unguided_cost_ = unguided_.per_path(0) / cost.per_path(lookup_rays_);
  const double efficiency_gain = unguided_variance / variance * unguided_cost_;
  if (!(efficiency_gain > 0)) return 0;
  const double before = checks_.empty() ? 0 : checks_.back().efficiency_gain;
  checks_.push_back({samples, efficiency_gain});
  if (open_) return efficiency_gain;
  // On a part, little is to be gained, and little is learned.
  const bool due = part_ || table_samples_seen >= kLeastEvents;
  const uint64_t old_samples = warm_ ? kWarm : (part_ ? kPart : 1) * kOld.samples;
  const bool old = table_samples_seen >= kOldEvents || (samples >= old_samples && (warm_ || due));
  double least = 0;
  if (samples >= kYoung.samples && due) least = kYoung.gain;
  if (old) least = part_ ? kPartGain : kOld.gain;
  if (efficiency_gain < std::min(least, kHope * before)) on_ = false;
  if (samples >= kYoung.samples && efficiency_gain >= kPartGain) part_ = false;
  if (!part_) judge_learning(samples, table_samples_seen, efficiency_gain);
  return efficiency_gain;
}

void GuideGate::judge_learning(uint64_t samples, uint64_t table_samples_seen,
                               double efficiency_gain) {
  bool little = false;
  for (const Check& c : checks_) {
    if (c.samples > samples / 2 || c.samples <= samples / 4) continue;
    const double brought = efficiency_gain / c.efficiency_gain;
    little |= brought < kLeastGrowth;
    if (samples >= kFirstEnd && brought < kLeastGain) learns_ = false;
  }
  if (little && brought_little_ && table_samples_seen >= kOldEvents) grows_ = false;
  brought_little_ = little;
}

}  // namespace qray
