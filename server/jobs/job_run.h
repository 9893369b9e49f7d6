// One job's way from queued to its end, on the runner's thread.
#pragma once

#include "core/settings/frames.h"
#include "server/jobs/job_runner.h"
#include "server/jobs/shared_pass_sampler.h"

namespace qray::server {

struct RunContext {
  Stores& stores;
  TaskPool& pool;
  MemoryBudget& memory;
  const Clock& clock;
  const std::function<int64_t()>& now_ms;
  const JobRunner::Render& render;
  double shared_pass_seconds;
  std::function<void(std::shared_ptr<RunningJob>)> show;  // to readers; null: no more
  std::function<void()> got_somewhere;                    // its first state was written
  JobKeeper& keeper;
  const Lease& lease;
  std::stop_token stop;      // cancel or shutdown
  std::stop_token stopping;  // shutdown: what is not done is left to the next start
};

class JobRun {
 public:
  JobRun(const RunContext& context, JobId id) : context_(context), id_(id) {}

  // Makes a queued job this run's. kCanceled: it is not queued any more. kIo: it is, and the disk
  // does not take the move.
  Status claim() { return try_move(JobState::kPreparing); }
  // One that was claimed as this record says.
  void claimed(JobRecord job) { job_ = std::move(job); }
  uint64_t claim_number() const { return job_.claim; }
  // After claim(). Runs to the job's end, to its pause, or back to the queue when the server stops.
  // What was interrupted goes on from its last checkpoint.
  void run();

 private:
  struct Rendered {
    JobResult result;
    std::string table_in;
  };
  Status prepare();
  Result<Rendered> resume_or_begin();
  std::optional<Checkpoint> checkpoint();
  Result<Rendered> resume(const Checkpoint& checkpoint);
  Result<Rendered> begin();
  // `resume_from`: null where the job begins.
  Result<Rendered> run_to_end(StartingGuide start, const std::string& network,
                              SnapshotReader* resume_from);
  using Parent = std::optional<TableHeader>;
  Result<JobResult> render_picture(StartingGuide start, const Parent& parent,
                                   const Recovery* recovery, const Checkpoints& checkpoints);
  Result<JobResult> render_frames(StartingGuide start, const Recovery* recovery,
                                  const Checkpoints& checkpoints);
  std::optional<Recovery> recovery(const std::string& wanted);
  // Who samples its passes, where other workers are to; null: this process alone.
  std::unique_ptr<SharedPassSampler> shared_sampler();
  void show_film();
  Status finish(Rendered rendered);
  Status may_write() const;  // kCanceled: another process may have the job
  void end(const Error& error);
  void keep_partial_picture();
  void count(double finalizing_seconds);  // what an ended job did
  void warn(std::string text);
  void log(std::string_view text);
  // Moves the state; a job that was canceled meanwhile gives kCanceled.
  Status try_move(JobState to, const JobStore::Change& change = {});
  // The same, again and again while the disk does not take it; kIo: stopped meanwhile.
  Status move(JobState to, const JobStore::Change& change = {});
  // Again, a second later? Says why there is need to, once.
  bool wait_for_disk(const Error& error, const std::stop_token& stop);

  RunContext context_;
  JobId id_;
  JobRecord job_;
  MemoryBudget::Part memory_;
  std::shared_ptr<const PreparedScene> scene_;
  RenderSettings settings_;
  bool of_frames_ = false;        // else the job is one picture
  std::vector<JobFrame> frames_;  // of which a plain job has one
  std::optional<RenderStats> last_pass_;
  std::string counted_;        // the statistics of its last success, before it was extended
  bool warm_ = false;          // started from a table
  bool mixed_builds_ = false;  // another build of qray has rendered a part
  bool disk_failed_ = false;   // and that was said
  std::shared_ptr<RunningJob> running_;
  std::vector<std::string> warnings_;
};

}  // namespace qray::server
