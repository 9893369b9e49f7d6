#include "server/jobs/job_queue.h"

#include <algorithm>

namespace qray::server {

Status JobQueue::push(JobId id, int priority, bool keep_bound, Clock::time_point now) {
  std::lock_guard lock(mutex_);
  if (keep_bound && waiting_.size() >= max_) {
    return Error{ErrorCode::kBusy, std::to_string(max_) + " jobs wait already; try again later",
                 ""};
  }
  waiting_.push_back({id, now - std::chrono::minutes(priority)});
  changed_.notify_one();
  return {};
}

std::optional<JobId> JobQueue::pop(std::stop_token stop) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, stop, [&] { return !waiting_.empty(); });
  if (stop.stop_requested() || waiting_.empty()) return std::nullopt;
  const auto next = std::min_element(
      waiting_.begin(), waiting_.end(),
      [](const Waiting& a, const Waiting& b) { return a.counts_since < b.counts_since; });
  const JobId id = next->id;
  waiting_.erase(next);
  return id;
}

bool JobQueue::remove(JobId id) {
  std::lock_guard lock(mutex_);
  return std::erase_if(waiting_, [&](const Waiting& w) { return w.id == id; }) > 0;
}

size_t JobQueue::size() const {
  std::lock_guard lock(mutex_);
  return waiting_.size();
}

}  // namespace qray::server
