// Until when this process may believe that a job is its own. A run looks before each file that it
// writes: one that was stopped for longer than its lease and wakes up writes nothing. Any thread.
#pragma once

#include <time.h>

#include <atomic>
#include <cstdint>

namespace qray::server {

class Lease {
 public:
  // Goes on while the machine sleeps or the process is stopped.
  static int64_t now_ms() {
    timespec now{};
    ::clock_gettime(CLOCK_BOOTTIME, &now);
    return int64_t{now.tv_sec} * 1000 + now.tv_nsec / 1'000'000;
  }
  bool holds() const { return now_ms() < until_ms_.load(std::memory_order_relaxed); }
  void extend_to(int64_t ms) { until_ms_.store(ms, std::memory_order_relaxed); }
  void lose() { extend_to(0); }

 private:
  std::atomic<int64_t> until_ms_{INT64_MAX};  // for ever: nobody else runs jobs
};

}  // namespace qray::server
