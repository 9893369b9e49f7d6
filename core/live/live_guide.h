// A session's guide: what it learns in the time that a frame can spare, and whether paths of a
// camera that moves ask it. That is judged where the camera rests, by the same gate as a job's
// (core/render/guide_decision.h), and holds until it rests elsewhere for long enough. One thread.
#pragma once

#include <memory>

#include "core/render/guide_decision.h"

namespace qray {

class LiveGuide {
 public:
  // `guide`: null, nothing is learned. `gate` false: it rules whatever it gains.
  LiveGuide(std::unique_ptr<Guide> guide, bool gate) : guide_(std::move(guide)), gate_(gate) {}

  const Guide* get() const { return guide_.get(); }
  std::unique_ptr<Guide> take() { return std::move(guide_); }
  // The guide while it is switched on, null while it is off or there is none.
  void switch_to(bool on) { on_ = on; }
  Guide* active() { return on_ ? guide_.get() : nullptr; }

  // The scene's light has changed: what it knows counts less, and it is to be judged anew.
  // `lights`: as they are now.
  void scene_changed(const LightClusters& lights);
  // Where the camera rests: what the gate has decided by now.
  void judged(const GuideDecision& decision);
  // Of a camera that moves: whether paths ask the guide, and whether it learns from them.
  bool guides() const;
  bool learns(bool whatever_time) const {
    return on_ && guide_ && !left_ && has_time(whatever_time);
  }
  // Of such a camera's frame of so many paths: learning from a few of them is enough.
  bool learns_from_few(uint64_t paths) const {
    return guide_->expects() &&
           GuideDecision::few_teach_enough(guide_->stats().samples_seen, paths);
  }
  // Learning took little of the last frames' time.
  bool has_time(bool whatever_time) const;
  void frame_took(double learning_seconds, double other_seconds);

 private:
  std::unique_ptr<Guide> guide_;
  const bool gate_;
  bool on_ = true;
  bool left_ = false;                                // it did not pay where the camera last rested
  double learning_seconds_ = 0, other_seconds_ = 0;  // of the last frames
};

}  // namespace qray
