// What next event estimation learns: which clusters of lights were picked where, and what came of
// it. Whether something is in the way is known once a batch of rays is answered, so picks are kept
// until then. One per PathTracer.
#pragma once

#include <vector>

#include "core/guide/guide.h"
#include "core/render/light_pick.h"

namespace qray {

class LightLearner {
 public:
  static constexpr uint32_t kNoPick = ~0u;
  struct Place {
    uint32_t index = 0;
    const float* weights = nullptr;  // LightPick::sample(); null: it is asked without
  };

  // Both outlive this. Null: there is no guide.
  LightLearner(const Guide* guide, const LightPick& lights)
      : plain_weights_(lights.plain_weights()) {
    const LightImportance* importance = guide ? guide->light_importance() : nullptr;
    if (importance && !importance->empty() && importance->clusters() == lights.clusters())
      importance_ = importance;
  }

  // `learns`: the pick that follows will be told to picked(), so that it must be of clusters.
  Place place(const LightReceiver& at, bool learns) const {
    if (!importance_) return {};
    const uint32_t index = importance_->place(at.p, at.n);
    const float* weights = importance_->weights(index);
    return {index, weights || !learns ? weights : plain_weights_};
  }
  // This light was picked there; nothing came of it so far.
  uint32_t picked(const Place& place, const LightSample& light) {
    if (!importance_) return kNoPick;
    picks_.push_back({place.index, light.cluster_count, light.clusters, 0});
    return static_cast<uint32_t>(picks_.size() - 1);
  }
  void sends(uint32_t pick, float estimate) {  // luminance
    if (pick != kNoPick) picks_[pick].estimate = estimate;
  }
  void flush() {
    for (const Pick& pick : picks_)
      importance_->record(pick.place, std::span(pick.clusters).first(pick.count), pick.estimate);
    discard();
  }
  void discard() { picks_.clear(); }

 private:
  struct Pick {
    uint32_t place, count;
    std::array<ClusterPick, 3> clusters;
    float estimate;
  };
  const LightImportance* importance_ = nullptr;
  const float* plain_weights_;
  std::vector<Pick> picks_;
};

}  // namespace qray
