// While it lives, turns a running job's numbers into events, at most two a second, on a thread of
// its own: publishing costs the render threads nothing but stores to memory.
#pragma once

#include <thread>

#include "server/jobs/lease.h"
#include "server/jobs/running_job.h"
#include "server/store/job_store.h"

namespace qray::server {

class ProgressTicker {
 public:
  // `claim`: of the job's run, whose lease this looks at. `learning`: its state is kLearning, to be
  // moved on when that is past. `frames`: it is a job of frames.
  ProgressTicker(JobStore& jobs, const RunningJob& job, uint64_t claim, const Lease& lease,
                 bool learning, bool frames = false);

 private:
  void watch(std::stop_token stop, JobStore& jobs, const RunningJob& job, uint64_t claim,
             const Lease& lease, bool learning, bool frames);
  std::jthread thread_;
};

}  // namespace qray::server
