// Hands deltas to the guide in the order of their numbers, whatever order they finish in. Any
// thread.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "core/base/clock.h"
#include "core/guide/guide_learner.h"

namespace qray {

class OrderedUpdates {
 public:
  // Both outlive this.
  OrderedUpdates(GuideLearner* guide, const Clock& clock) : guide_(guide), clock_(clock) {}

  // `first`: the number of the first delta that will finish. None are under way.
  void start(size_t first) {
    next_ = first;
    waiting_.clear();
  }

  std::unique_ptr<GuideDelta> empty_delta() {
    std::lock_guard lock(mutex_);
    if (free_.empty()) return guide_->make_delta();
    std::unique_ptr<GuideDelta> delta = std::move(free_.back());
    free_.pop_back();
    return delta;
  }
  void finish(size_t number, std::unique_ptr<GuideDelta> delta) {
    std::lock_guard lock(mutex_);
    const double start = clock_.seconds();
    waiting_[number] = std::move(delta);
    for (auto first = waiting_.begin(); first != waiting_.end() && first->first == next_;
         first = waiting_.begin(), ++next_) {
      guide_->update(*first->second);
      free_.push_back(std::move(first->second));
      waiting_.erase(first);
    }
    seconds_ += clock_.seconds() - start;
  }
  // That the guide took for them, of one thread; while no delta is under way.
  double seconds() const { return seconds_; }

 private:
  GuideLearner* guide_;
  const Clock& clock_;
  std::mutex mutex_;
  size_t next_ = 0;
  double seconds_ = 0;
  std::map<size_t, std::unique_ptr<GuideDelta>> waiting_;
  std::vector<std::unique_ptr<GuideDelta>> free_;
};

}  // namespace qray
