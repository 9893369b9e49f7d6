// Of a store that several processes share: who of them runs which job. A claim is believed for a
// lease, which its worker renews; a job whose lease is over is queued again, and its old run's
// moves are refused. Any thread.
#pragma once

#include <chrono>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "server/model/job.h"

namespace qray::server {

// A process that runs jobs.
struct WorkerInfo {
  std::string id, host;
  std::string kind;         // "front": it also answers requests; "worker"
  std::string build, bits;  // bits: bits_of_machine.h
  int threads = 0;
  bool draining = false;  // it takes no more jobs
  uint64_t samples = 0;   // of all its jobs, since it started
  double samples_a_second = 0;
  std::optional<JobId> helps;  // whose passes it samples with others
  // From here on filled in by the store.
  double age_seconds = 0, silent_seconds = 0;
  std::vector<JobId> jobs;
  std::string aside;  // why it was put aside; empty: it was not
};

class SharedJobs {
 public:
  virtual ~SharedJobs() = default;

  // The job that is next, as this process's: it is `preparing`. None: there is none.
  // `suspects_too`: also those that have ended their server too often to run beside others.
  virtual Result<std::optional<JobRecord>> claim(bool suspects_too) = 0;

  virtual Result<size_t> queued() const = 0;  // jobs

  struct Run {
    JobId id;
    uint64_t claim = 0;
    proto::JobProgress progress;
  };
  struct Held {
    JobId id;
    JobState state;
  };
  // Renews the leases of these runs and says how the jobs stand; those that are missing in the
  // answer are not this process's any more.
  virtual Result<std::vector<Held>> renew(std::span<const Run> runs) = 0;
  // How long a renewal is believed.
  virtual std::chrono::milliseconds lease() const = 0;
  // Queues again, or ends, the jobs whose leases are over: these, and those that the start of this
  // process took up. Their files may be half-written.
  virtual Result<std::vector<JobId>> take_up_lost() = 0;

  // Until a job was queued or a running one's state was changed, by any process; or for `time`. It
  // may not be told: what it waits for must be looked at all the same.
  virtual void wait_for_news(std::stop_token stop, std::chrono::milliseconds time) = 0;

  // Says that this process is there. False: it is to take no more jobs.
  virtual Result<bool> present(const WorkerInfo& me) = 0;
  virtual Status leave() = 0;  // it stops
  virtual Result<std::vector<WorkerInfo>> workers() const = 0;
  virtual Status drain(const std::string& worker) = 0;  // kNotFound
};

}  // namespace qray::server
