// While it lives, deletes jobs that ended longer ago than they are kept, on a thread of its own.
#pragma once

#include <thread>

#include "server/jobs/job_runner.h"

namespace qray::server {

class Janitor {
 public:
  // `keep_days` <= 0: all are kept.
  Janitor(JobRunner& runner, const JobStore& jobs, double keep_days,
          std::function<int64_t()> now_ms);

  // What is due now; how many were deleted.
  static size_t sweep(JobRunner& runner, const JobStore& jobs, double keep_days, int64_t now_ms);

 private:
  std::jthread thread_;
};

}  // namespace qray::server
