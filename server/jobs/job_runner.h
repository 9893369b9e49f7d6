// Accepts jobs and runs them, one at a time on all render threads. Exceptions and bad scenes end a
// job, never the server. Any thread may submit, cancel and look; start and stop from one.
#pragma once

#include <mutex>
#include <thread>

#include "core/base/task_pool.h"
#include "core/job/run_job.h"
#include "server/jobs/job_queue.h"
#include "server/jobs/live_job.h"
#include "server/store/job_store.h"
#include "server/store/result_store.h"
#include "server/store/scene_store.h"
#include "server/store/table_store.h"
#include "server/store/weights_store.h"

namespace qray::server {

class Metrics;

struct Stores {
  JobStore& jobs;
  TableStore& tables;
  WeightsStore& weights;
  ResultStore& results;
  SceneStore& scenes;
  Metrics* metrics = nullptr;  // may be
};

class JobRunner {
 public:
  JobRunner(Stores stores, int threads, size_t max_queued, const Clock& clock,
            std::function<int64_t()> now_ms);
  ~JobRunner() { stop(); }

  // Takes up the jobs that a restart found, then runs.
  void start(const std::vector<JobId>& recovered);
  // Puts the running job back into the queue of the next start.
  void stop();

  // Durable when it returns. kBusy: the queue is full.
  Result<JobRecord> submit(const proto::JobRequest& request);
  // kConflict: it has ended. A running job ends soon after.
  Result<JobRecord> cancel(JobId id);
  // The running job, if it is this one and has a film.
  std::shared_ptr<const LiveJob> live(JobId id) const;

 private:
  void work(std::stop_token stop);

  Stores stores_;
  JobQueue queue_;
  TaskPool pool_;
  const Clock& clock_;
  std::function<int64_t()> now_ms_;

  std::mutex submit_mutex_;   // the queue's bound holds over several submits at once
  mutable std::mutex mutex_;  // guards what follows
  JobId running_;
  std::stop_source cancel_running_;
  std::shared_ptr<LiveJob> live_;
  std::jthread worker_;
};

}  // namespace qray::server
