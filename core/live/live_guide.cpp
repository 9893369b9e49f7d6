#include "core/live/live_guide.h"

namespace qray {
namespace {

constexpr double kMostLearning = 0.08;  // of the time
constexpr double kForget = 0.9;         // of times, each frame

}  // namespace

void LiveGuide::scene_changed(const LightClusters& lights) {
  if (guide_) {
    guide_->set_lights(lights);
    guide_->doubt();
  }
  left_ = false;
}

void LiveGuide::judged(const GuideDecision& decision) {
  if (!decision.on())
    left_ = true;
  else if (!decision.passes().empty() && decision.passes().back().efficiency_gain >= 1)
    left_ = false;
}

bool LiveGuide::guides() const {
  if (!on_ || !guide_ || left_) return false;
  return !gate_ || !guide_->expects() || GuideGate::knows_enough(guide_->stats().samples_seen);
}

bool LiveGuide::has_time(bool whatever_time) const {
  return whatever_time || learning_seconds_ <= kMostLearning * (learning_seconds_ + other_seconds_);
}

void LiveGuide::frame_took(double learning_seconds, double other_seconds) {
  learning_seconds_ = kForget * learning_seconds_ + learning_seconds;
  other_seconds_ = kForget * other_seconds_ + other_seconds;
}

}  // namespace qray
