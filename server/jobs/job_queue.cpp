#include "server/jobs/job_queue.h"

#include <algorithm>

namespace qray::server {

void JobQueue::push(JobId id, int priority, Clock::time_point now) {
  std::lock_guard lock(mutex_);
  waiting_.push_back({id, priority, now});
  changed_.notify_one();
}

std::optional<JobId> JobQueue::pop(std::stop_token stop) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, stop, [&] { return !waiting_.empty(); });
  if (stop.stop_requested() || waiting_.empty()) return std::nullopt;
  const auto next = std::min_element(
      waiting_.begin(), waiting_.end(),
      [](const Waiting& a, const Waiting& b) { return a.counts_since() < b.counts_since(); });
  const JobId id = next->id;
  waiting_.erase(next);
  return id;
}

bool JobQueue::remove(JobId id) {
  std::lock_guard lock(mutex_);
  return std::erase_if(waiting_, [&](const Waiting& w) { return w.id == id; }) > 0;
}

void JobQueue::set_priority(JobId id, int priority) {
  std::lock_guard lock(mutex_);
  for (Waiting& waiting : waiting_)
    if (waiting.id == id) waiting.priority = priority;
}

size_t JobQueue::size() const {
  std::lock_guard lock(mutex_);
  return waiting_.size();
}

size_t JobQueue::room() const {
  std::lock_guard lock(mutex_);
  return max_ - std::min(waiting_.size(), max_);
}

}  // namespace qray::server
