// What a render decides about its guide from pass to pass: whether paths ask it, whether it learns
// and grows (guide_gate.h), and whether the noise of its samples has changed. Between passes, one
// thread.
#pragma once

#include <vector>

#include "core/guide/guide.h"
#include "core/render/guide_gate.h"
#include "core/render/guided_pixels.h"
#include "core/render/noise_estimate.h"
#include "core/render/stats.h"

namespace qray {

class GuideDecision {
 public:
  // The guide outlives this. `open`: it rules whatever it gains. `view_lasts`: no other camera will
  // use it, so that it need not grow where this one's picture gains nothing by it.
  GuideDecision(Guide& guide, bool open, bool view_lasts);
  // Before the first pass: a pilot left this gate, and cost as much.
  void begin_after(const GuideGate& gate, const PassCost& cost, const PassCost& guided_cost);

  // Whether a guide that has seen so many events learns enough of a pass of so many paths from one
  // pixel in GuidedPixels::kFew.
  static bool few_teach_enough(uint64_t seen, uint64_t paths,
                               double events_a_path = kMostEventsAPath);

  // Of a pass of so many paths that starts after `samples` a pixel. `may_learn`: the plan has room
  // for it.
  void start_pass(uint64_t samples, uint64_t paths, bool may_learn);
  bool guided() const { return guided_; }      // paths of this pass ask the guide
  bool learning() const { return learning_; }  // it learns from this pass
  // For which pixels: on a part where it is on trial; from few where it knows much more than the
  // pass can tell.
  GuidedPixels pixels() const { return {guided_, learning_, part_, few_, passes_.size()}; }
  // Since noise was last measured, passes were guided by what changed: they weigh by their noise.
  bool noise_changed() const { return guide_.expects() && changing_; }

  // After a pass, `samples` a pixel being done, which cost `cost` with all passes before it,
  // `guided_cost` of that its guided paths. `noise`: null where this pass did not measure it.
  void judge(uint64_t samples, const PassCost& cost, const PassCost& guided_cost,
             const NoiseEstimate* noise);

  bool on() const { return gate_.on(); }
  bool awake(uint64_t samples) const { return gate_.awake(samples); }
  const GuideGate& gate() const { return gate_; }
  const std::vector<GuidePass>& passes() const { return passes_; }

  template <class Self, class Archive>
  static void exchange(Self& self, Archive& archive) {
    archive(self.gate_, self.cost_, self.guided_cost_, self.guided_, self.learning_, self.part_,
            self.few_, self.paths_, self.seen_, self.events_a_path_, self.changing_, self.passes_,
            self.before_.efficiency_gain, self.before_.unguided_cost, self.seen_before_);
  }

 private:
  void tell_worth(const GuideWorth& now);

  Guide& guide_;
  const bool view_lasts_;
  GuideGate gate_;
  PassCost cost_, guided_cost_;  // of all passes
  bool guided_ = false, learning_ = false, part_ = false, few_ = false;
  bool changing_ = false;
  static constexpr double kMostEventsAPath = 16;  // a guess that is rather too high
  // Of a job's first pass. If too few paths teach there, the next one is measured by it.
  static constexpr double kFirstEventsAPath = 4;
  // Of the pass under way: its paths, and what the guide had seen. Of the last one that it learned
  // from: how much it saw for a path.
  uint64_t paths_ = 0, seen_ = 0;
  double events_a_path_ = kFirstEventsAPath;
  // Before all passes: what the table was worth, and what it had seen.
  GuideWorth before_;
  uint64_t seen_before_ = 0;
  std::vector<GuidePass> passes_;
};

}  // namespace qray
