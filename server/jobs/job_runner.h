// Accepts jobs and runs them, some at once, sharing all render threads by their priorities.
// Exceptions and bad scenes end a job, never the server. Any thread may submit and look; start and
// stop from one.
#pragma once

#include <condition_variable>
#include <map>
#include <mutex>
#include <thread>

#include "core/base/task_pool.h"
#include "core/job/run_job.h"
#include "server/jobs/gather.h"
#include "server/jobs/job_keeper.h"
#include "server/jobs/job_queue.h"
#include "server/jobs/lease.h"
#include "server/jobs/pass_helper.h"
#include "server/jobs/running_job.h"
#include "server/jobs/worker_speed.h"
#include "server/policy/memory_budget.h"
#include "server/store/job_store.h"
#include "server/store/moment_store.h"
#include "server/store/result_store.h"
#include "server/store/scene_store.h"
#include "server/store/shared_jobs.h"
#include "server/store/shared_passes.h"
#include "server/store/table_store.h"
#include "server/store/weights_store.h"

namespace qray::server {

class JobRun;
class Metrics;
struct RunContext;

struct Stores {
  JobStore& jobs;
  TableStore& tables;
  WeightsStore& weights;
  ResultStore& results;
  SceneStore& scenes;
  CheckpointStore& checkpoints;
  MomentStore& moments;
  Metrics* metrics = nullptr;      // may be
  SharedJobs* shared = nullptr;    // where other processes run jobs too
  SharedPasses* passes = nullptr;  // and may sample passes of them together
};

class JobRunner {
 public:
  struct Limits {
    int threads = 1;  // of rendering
    int at_once = 1;  // jobs; 0, where others run them: none here
    size_t max_queued = 1000;
    size_t memory_bytes = size_t{8} << 30;  // of all that run at once
    std::string kind = "front";             // WorkerInfo::kind
    double shared_pass_seconds = 0.25;      // a pass that takes less is not shared
  };
  // `render`: what makes the pictures; tests have one that takes no time.
  using Render = std::function<decltype(run_guided_job)>;
  JobRunner(Stores stores, const Limits& limits, const Clock& clock,
            std::function<int64_t()> now_ms, Render render = run_guided_job);
  ~JobRunner() { stop(); }

  // Takes up the jobs that a restart found, then runs.
  void start(const std::vector<JobRecord>& recovered);
  // Running jobs write their states and go back into the queue of the next start; those that take
  // longer than a few seconds go on from their last state then.
  void stop();

  // Durable when it returns. kBusy: the queue is full; kConflict: the key was used for another
  // request. A job of the same key and request, of the last day, is the answer itself.
  Result<JobRecord> submit(const JobRequest& request,
                           const std::optional<JobStore::IdempotencyKey>& key = {});
  // kConflict: it has ended. A running job ends soon after.
  Result<JobRecord> cancel(JobId id);
  // kConflict: it has ended, or is about to. A running job writes its state and is paused soon
  // after.
  Result<JobRecord> pause(JobId id);
  // kConflict: it is not paused; kBusy: the queue is full.
  Result<JobRecord> resume(JobId id);
  // More onto a job that has succeeded. kConflict: it has not, or its state is not kept any more;
  // kInvalid: more than a job may have; kBusy as above.
  Result<JobRecord> extend(JobId id, const proto::ExtendRequest& more);
  // Of a job that has succeeded, but for frames that were canceled: it renders those.
  Result<JobRecord> go_on(JobId id);
  // Labels of a job in any state; the priority counts where it waits, and in its next run.
  Result<JobRecord> update(JobId id, const proto::JobUpdate& update);
  // Forgets an ended job and its picture. kConflict: it has not ended.
  Status remove(JobId id);

  // A running job that has a film.
  std::shared_ptr<const RunningJob> running(JobId id) const;
  // For others to share with jobs.
  const TaskPool& pool() const { return pool_; }
  MemoryBudget& memory() { return memory_; }
  size_t queued() const { return queue_.size(); }
  // Takes no more jobs; what runs here is rendered to its end. Then is_drained().
  void drain();
  bool is_drained() const;

 private:
  struct Running {
    std::stop_source cancel;
    std::shared_ptr<JobKeeper> keeper;
    std::shared_ptr<Lease> lease;
    std::shared_ptr<RunningJob> shown{};  // null until it has a film
    uint64_t claim = 0;
    bool asked_alone = false;  // to be alone to its end
  };
  size_t places() const;  // in the queue
  Status room() const;    // kBusy: none
  std::vector<Result<JobRecord>> accept(std::span<const JobStore::Posted> posted);
  Result<JobRecord> enqueue(const JobRecord& job);
  void work(std::stop_token stop);
  Running new_run(JobId id) const;
  // What a run is told, and whom it tells. `share` and the keeper outlive it.
  RunContext context_of(JobId id, const Running& running, TaskPool& share, std::stop_token stop);
  // Of a job that is among running_.
  void carry_out(JobRun& run, JobId id);
  // Where several processes share the jobs (shared_runs.cpp): runs what it claims of them.
  void work_shared(std::stop_token stop);
  void help_others();
  std::optional<JobRecord> claim_shared(std::stop_token stop);
  void run_shared(const JobRecord& job, std::stop_token stop);
  // Renews the leases of what runs here, passes on what others ask of it, and takes up what others
  // have lost.
  void keep_leases(std::stop_token stop);
  bool renew_leases();
  void take_up_lost();
  bool be_present();
  // kIo: it is still queued, as the disk does not say what it is, or does not take it.
  Status run(JobId id, std::stop_token stop);
  bool is_queued(JobId id) const;
  // Beside those that run. A job may ask to run alone. Of several jobs that ended the server
  // together, one is to blame: each runs alone from its last attempt but one, until it has got
  // somewhere.
  bool may_run(JobId id, bool alone) const;
  // Moves it into the queue.
  Result<JobRecord> extendable(JobId id) const;
  Result<JobRecord> queue_again(JobId id, const JobStore::Change& change);
  // Moves a job that may be queued or running: `to_when` says to what from its present state.
  Result<JobRecord> move_running(JobId id, const std::function<JobState(JobState)>& to_when,
                                 const std::function<void(Running&)>& tell);

  Stores stores_;
  const Limits limits_;
  JobQueue queue_;
  TaskPool pool_;
  MemoryBudget memory_;
  const Clock& clock_;
  std::function<int64_t()> now_ms_;
  const Render render_;

  Gather<JobStore::Posted, Result<JobRecord>> submits_;
  std::mutex submit_mutex_;  // the queue's bound holds over several submits at once
  // Guards what follows, and that a job is in the queue while its state says so: who moves it into
  // or out of that state holds this.
  mutable std::mutex mutex_;
  std::condition_variable_any ended_;  // or has got somewhere, or left the queue
  std::map<JobId, Running> running_;
  std::optional<JobId> alone_;  // that runs alone
  int wait_to_be_alone_ = 0;    // so many jobs, before others
  bool draining_ = false;
  std::mutex claim_mutex_;  // one thread claims at a time
  WorkerSpeed speed_;       // of the thread that keeps leases
  std::optional<PassHelper> helper_;
  std::vector<std::jthread> workers_;
};

}  // namespace qray::server
