// Jobs that wait to run: those of higher priority first, of one priority the
// oldest. Each minute of waiting counts as a step of priority, so that none waits for ever. Any
// thread.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <stop_token>
#include <vector>

#include "core/base/result.h"
#include "server/model/job.h"

namespace qray::server {

class JobQueue {
 public:
  using Clock = std::chrono::steady_clock;
  explicit JobQueue(size_t max) : max_(max) {}

  // Whatever room there is: who accepts jobs asks before.
  void push(JobId id, int priority, Clock::time_point now = Clock::now());
  // Waits; none when a stop is asked for.
  std::optional<JobId> pop(std::stop_token stop);
  bool remove(JobId id);
  // Of one that waits; how long it has waited counts on.
  void set_priority(JobId id, int priority);
  size_t size() const;
  size_t room() const;

 private:
  struct Waiting {
    JobId id;
    int priority;
    Clock::time_point since;
    // The earliest is next: priority moves it back.
    Clock::time_point counts_since() const { return since - std::chrono::minutes(priority); }
  };
  const size_t max_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::vector<Waiting> waiting_;  // in the order of their pushes
};

}  // namespace qray::server
