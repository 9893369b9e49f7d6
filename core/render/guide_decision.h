// What a render decides about its guide from pass to pass: whether paths ask it, whether it learns
// and grows (guide_gate.h), and whether the noise of its samples has changed. Between passes, one
// thread.
#pragma once

#include <vector>

#include "core/guide/guide.h"
#include "core/render/guide_gate.h"
#include "core/render/noise_estimate.h"
#include "core/render/prepared_scene.h"
#include "core/render/stats.h"

namespace qray {

class GuideDecision {
 public:
  // The guide outlives this. `open`: it rules whatever it gains. `view_lasts`: no other camera will
  // use it, so that it need not grow where this one's picture gains nothing by it.
  GuideDecision(const PreparedScene& scene, Guide& guide, bool open, bool view_lasts);

  // Of a pass that starts after `samples` a pixel. `may_learn`: the plan has room for it.
  void start_pass(uint64_t samples, bool may_learn);
  bool guided() const { return guided_; }      // paths of this pass ask the guide
  bool learning() const { return learning_; }  // it learns from this pass
  // Since noise was last measured, passes were guided by what changed: they weigh by their noise.
  bool noise_changed() const { return guide_.expects() && changing_; }

  // After a pass, `samples` a pixel being done, which cost `cost` with all passes before it.
  // `noise`: null where this pass did not measure it.
  void judge(uint64_t samples, const PassCost& cost, const NoiseEstimate* noise);

  bool on() const { return gate_.on(); }
  const std::vector<GuidePass>& passes() const { return passes_; }

  template <class Self, class Archive>
  static void exchange(Self& self, Archive& archive) {
    archive(self.gate_, self.cost_, self.guided_, self.learning_, self.changing_, self.passes_);
  }

 private:
  Guide& guide_;
  const bool view_lasts_;
  GuideGate gate_;
  PassCost cost_;  // of all passes
  bool guided_ = false, learning_ = false;
  bool changing_ = false;
  std::vector<GuidePass> passes_;
};

}  // namespace qray
