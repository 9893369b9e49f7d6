#include "core/render/guide_decision.h"

#include <algorithm>
#include <cmath>

namespace qray {
namespace {

// What a vertex costs more where the guide is asked, in rays with all that is done for them.
// Measured: .33 (many-lights) to 1.2 (ajar-door).
constexpr double kLookupRays = 0.5;
// A guide knows much more than a pass can tell if it has seen that many times as much: no cold
// job's passes, each up to half of what was before, come to that. And how many paths tell at least
// what the guide saves.
constexpr double kKnowsMore = 4;
constexpr uint64_t kLeastPaths = 2048;
// Of what a table is worth: the share of what was measured last.
constexpr double kLeastNews = 0.25;

}  // namespace

GuideDecision::GuideDecision(Guide& guide, bool open, bool view_lasts)
    : guide_(guide),
      view_lasts_(view_lasts),
      gate_(kLookupRays, guide.stats().samples_seen > 0, open, guide.worth()),
      before_(guide.worth()),
      seen_before_(guide.stats().samples_seen) {}

void GuideDecision::begin_after(const GuideGate& gate, const PassCost& cost,
                                const PassCost& guided_cost) {
  gate_ = gate;
  cost_ = cost;
  guided_cost_ = guided_cost;
}

bool GuideDecision::few_teach_enough(uint64_t seen, uint64_t paths, double events_a_path) {
  return paths >= kLeastPaths * GuidedPixels::kFew &&
         static_cast<double>(seen) >= kKnowsMore * events_a_path * static_cast<double>(paths);
}

void GuideDecision::start_pass(uint64_t samples, uint64_t paths, bool may_learn) {
  learning_ = may_learn && gate_.learns(samples);
  const bool was_all_guided = guided_ && !part_;
  part_ = learning_ && gate_.on_part();  // a trial ends with learning
  paths_ = paths;
  seen_ = guide_.stats().samples_seen;
  few_ = guide_.expects() && !part_ && few_teach_enough(seen_, paths, events_a_path_);
  guided_ = !guide_.expects() ||
            (gate_.guides(samples, guide_.stats().samples_seen) && part_ == gate_.on_part());
  const bool all_guided = guided_ && !part_;
  changing_ |= (all_guided && learning_) || all_guided != was_all_guided;
}

void GuideDecision::judge(uint64_t samples, const PassCost& cost, const PassCost& guided_cost,
                          const NoiseEstimate* noise) {
  const PassCost guided_pass = guided_cost - guided_cost_;
  const bool unguided = !guided_ || part_;  // most pixels
  gate_.unguided(cost - cost_ - guided_pass, noise && unguided ? noise->variance() : 0);
  cost_ = cost;
  guided_cost_ = guided_cost;
  GuidePass record{samples, guided_, learning_, part_ ? 1.0 / GuideGate::kPart : 1.0, 0, 0,
                   0,       0,       0};
  if (noise) {
    changing_ = false;
    record.variance = noise->variance();
    if (guided_ && guide_.expects() && gate_.on())
      record.efficiency_gain = gate_.guided(samples, guide_.stats().samples_seen, guided_pass,
                                            noise->guided_variance(), noise->unguided_variance());
    if (record.efficiency_gain > 0) tell_worth({record.efficiency_gain, gate_.unguided_cost()});
    if (view_lasts_ && !gate_.grows()) guide_.stop_growing();
  }
  const GuideStats table = guide_.stats();
  if (learning_ && !part_ && table.samples_seen > seen_)
    events_a_path_ = static_cast<double>(table.samples_seen - seen_) *
                     (few_ ? GuidedPixels::kFew : 1) / static_cast<double>(paths_);
  record.states = table.states;
  record.direction_nodes = table.direction_nodes;
  record.table_bytes = table.bytes;
  passes_.push_back(record);
}

// One view, or a few passes, may tell otherwise than those before: what is new counts by what the
// table has learned since.
void GuideDecision::tell_worth(const GuideWorth& now) {
  const double seen = static_cast<double>(guide_.stats().samples_seen);
  const double share = std::max(kLeastNews, 1 - static_cast<double>(seen_before_) / seen);
  if (!(before_.efficiency_gain > 0 && before_.unguided_cost > 0 && share < 1))
    return guide_.set_worth(now);
  const auto between = [share](double a, double b) { return a * std::pow(b / a, share); };
  guide_.set_worth({between(before_.efficiency_gain, now.efficiency_gain),
                    between(before_.unguided_cost, now.unguided_cost)});
}

}  // namespace qray
