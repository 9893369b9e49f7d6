// Jobs that wait to run, oldest first, at most so many. Any thread.
#pragma once

#include <condition_variable>
#include <deque>
#include <mutex>
#include <stop_token>

#include "core/base/result.h"
#include "server/jobs/job.h"

namespace qray::server {

class JobQueue {
 public:
  explicit JobQueue(size_t max) : max_(max) {}

  // kBusy when full. `keep_bound` off: for jobs that were accepted before a restart.
  Status push(JobId id, bool keep_bound = true);
  // Waits; none when a stop is asked for.
  std::optional<JobId> pop(std::stop_token stop);
  bool remove(JobId id);
  size_t size() const;
  bool full() const { return size() >= max_; }

 private:
  const size_t max_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<JobId> waiting_;
};

}  // namespace qray::server
