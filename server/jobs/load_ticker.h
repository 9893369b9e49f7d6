// Tells the events how far a job's scene is loaded, at most twice a second. Any thread.
#pragma once

#include <mutex>
#include <stop_token>

#include "core/base/clock.h"
#include "core/import/load_watch.h"
#include "server/store/job_store.h"

namespace qray::server {

class LoadTicker {
 public:
  LoadTicker(JobStore& jobs, JobId id, const Clock& clock, std::stop_token stop)
      : jobs_(jobs),
        id_(id),
        clock_(clock),
        stop_(std::move(stop)),
        start_(clock.seconds()),
        last_(start_) {}

  LoadWatch watch() {
    return [this](LoadStep step, double fraction) { return tell(step, fraction); };
  }

 private:
  bool tell(LoadStep step, double fraction);

  JobStore& jobs_;
  const JobId id_;
  const Clock& clock_;
  const std::stop_token stop_;
  const double start_;
  std::mutex mutex_;
  double last_;  // seconds of clock_: of the last event, or the start
};

}  // namespace qray::server
