// Hands tiles' deltas to the guide in tile order, whatever order they finish in. Any thread.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "core/guide/guide_learner.h"

namespace qray {

class OrderedUpdates {
 public:
  explicit OrderedUpdates(GuideLearner* guide) : guide_(guide) {}

  std::unique_ptr<GuideDelta> empty_delta() {
    std::lock_guard lock(mutex_);
    if (free_.empty()) return guide_->make_delta();
    std::unique_ptr<GuideDelta> delta = std::move(free_.back());
    free_.pop_back();
    return delta;
  }
  void finish(size_t tile, std::unique_ptr<GuideDelta> delta) {
    std::lock_guard lock(mutex_);
    waiting_[tile] = std::move(delta);
    for (auto first = waiting_.begin(); first != waiting_.end() && first->first == next_;
         first = waiting_.begin(), ++next_) {
      guide_->update(*first->second);
      free_.push_back(std::move(first->second));
      waiting_.erase(first);
    }
  }
  void start_pass(size_t first_tile) { next_ = first_tile; }

 private:
  GuideLearner* guide_;
  std::mutex mutex_;
  size_t next_ = 0;
  std::map<size_t, std::unique_ptr<GuideDelta>> waiting_;
  std::vector<std::unique_ptr<GuideDelta>> free_;
};

}  // namespace qray
