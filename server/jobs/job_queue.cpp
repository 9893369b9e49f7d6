#include "server/jobs/job_queue.h"

#include <algorithm>

namespace qray::server {

Status JobQueue::push(JobId id, bool keep_bound) {
  std::lock_guard lock(mutex_);
  if (keep_bound && waiting_.size() >= max_) {
    return Error{ErrorCode::kBusy, std::to_string(max_) + " jobs wait already; try again later",
                 ""};
  }
  waiting_.push_back(id);
  changed_.notify_one();
  return {};
}

std::optional<JobId> JobQueue::pop(std::stop_token stop) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, stop, [&] { return !waiting_.empty(); });
  if (stop.stop_requested() || waiting_.empty()) return std::nullopt;
  const JobId id = waiting_.front();
  waiting_.pop_front();
  return id;
}

bool JobQueue::remove(JobId id) {
  std::lock_guard lock(mutex_);
  return std::erase(waiting_, id) > 0;
}

size_t JobQueue::size() const {
  std::lock_guard lock(mutex_);
  return waiting_.size();
}

}  // namespace qray::server
