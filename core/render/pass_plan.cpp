#include "core/render/pass_plan.h"

#include <algorithm>
#include <bit>
#include <numeric>

namespace qray {
PassPlan::PassPlan(const RenderSettings& settings, int most_samples)
    : settings_(settings), most_samples_(most_samples) {
  if (!settings.passes.empty()) {
    total_ = std::accumulate(settings.passes.begin(), settings.passes.end(), int64_t{0});
  } else if (settings.samples > 0) {
    total_ = settings.samples;
  }
}

bool PassPlan::over(const RenderAge& age) const {
  if (!settings_.passes.empty()) return passes_.size() == settings_.passes.size();
  if (settings_.noise > 0 && age.noise > 0 && age.noise <= settings_.noise) return true;
  if (total_ > 0 && static_cast<int64_t>(age.samples) >= total_) return true;
  return settings_.seconds > 0 && !passes_.empty() && age.seconds >= settings_.seconds;
}

int PassPlan::start(const RenderAge& age, double last_pass_seconds) {
  if (over(age)) return 0;
  if (!settings_.passes.empty()) return passes_.emplace_back(settings_.passes[passes_.size()]);
  int64_t n =
      std::clamp<int64_t>(static_cast<int64_t>(std::bit_floor(age.samples) / 2), 1, most_samples_);
  if (total_ > 0) n = std::min(n, total_ - static_cast<int64_t>(age.samples));
  if (settings_.seconds > 0 && !passes_.empty()) {
    const double sample_seconds = std::max(last_pass_seconds / passes_.back(), 1e-9);
    const double fits = (settings_.seconds - age.seconds) / sample_seconds;
    hurries_ |= fits < 1;
    n = std::min(n, static_cast<int64_t>(std::clamp(fits, 1.0, 1e9)));
  }
  return passes_.emplace_back(static_cast<int>(n));
}

bool PassPlan::learning(const RenderAge& age) const {
  if (age.samples >= static_cast<uint64_t>(settings_.learning_samples) || hurries_) return false;
  if (!settings_.passes.empty() || age.samples == 0) return true;
  if (settings_.seconds > 0 && age.seconds > settings_.seconds / 2) return false;
  return total_ == 0 || age.samples < static_cast<uint64_t>(std::max<int64_t>(1, total_ / 2));
}

bool PassPlan::out_of_time(const RenderAge& age) const {
  return settings_.passes.empty() && settings_.seconds > 0 && age.samples > 0 &&
         age.seconds >= settings_.seconds;
}

double PassPlan::fraction(const RenderAge& age, double in_pass) const {
  const double done = static_cast<double>(age.samples) + in_pass;
  double f = total_ > 0 ? done / static_cast<double>(total_) : 0;
  if (settings_.passes.empty()) {
    if (settings_.seconds > 0) f = std::max(f, age.seconds / settings_.seconds);
    // Squared errors fall with the number of samples.
    if (settings_.noise > 0 && age.noise > 0)
      f = std::max(f, settings_.noise * settings_.noise / (age.noise * age.noise));
  }
  return std::min(f, 1.0);
}

}  // namespace qray
