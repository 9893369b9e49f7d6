#include "server/store/event_log.h"

#include <algorithm>

#include "core/base/check.h"

namespace qray::server {

void EventLog::restore(uint64_t lost_up_to, std::vector<Event> events, uint64_t newest) {
  QRAY_CHECK(this->newest() == 0);
  {
    std::lock_guard lock(mutex_);
    lost_ = lost_up_to;
  }
  for (Event& event : events) publish(std::move(event));
  std::lock_guard lock(mutex_);
  QRAY_CHECK(newest >= newest_);
  newest_ = newest;
}

void EventLog::publish(Event event) {
  std::lock_guard lock(mutex_);
  QRAY_CHECK(event.id > newest_);
  newest_ = event.id;
  ring_.push_back(std::move(event));
  if (ring_.size() > capacity_) {
    lost_ = ring_.front().id;
    ring_.pop_front();
  }
  changed_.notify_all();
}

void EventLog::close() {
  std::lock_guard lock(mutex_);
  closed_ = true;
  changed_.notify_all();
}

EventLog::Batch EventLog::wait(uint64_t cursor, const std::string& job,
                               std::chrono::milliseconds timeout) const {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  std::unique_lock lock(mutex_);
  Batch batch;
  if (cursor < lost_ || cursor > newest_) {
    batch.reset = true;
    batch.cursor = newest_;
    return batch;
  }
  batch.cursor = cursor;
  for (;;) {
    const auto first = std::upper_bound(ring_.begin(), ring_.end(), batch.cursor,
                                        [](uint64_t id, const Event& e) { return id < e.id; });
    for (auto it = first; it != ring_.end(); ++it) {
      if (job.empty() || it->job == job) batch.events.push_back(*it);
    }
    batch.cursor = newest_;
    if (!batch.events.empty() || closed_) return batch;
    if (changed_.wait_until(lock, deadline) == std::cv_status::timeout) return batch;
  }
}

uint64_t EventLog::newest() const {
  std::lock_guard lock(mutex_);
  return newest_;
}

bool EventLog::closed() const {
  std::lock_guard lock(mutex_);
  return closed_;
}

}  // namespace qray::server
