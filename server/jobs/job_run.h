// One job's way from queued to its end, on the runner's thread.
#pragma once

#include "server/jobs/job_runner.h"

namespace qray::server {

struct RunContext {
  Stores& stores;
  TaskPool& pool;
  MemoryBudget& memory;
  const Clock& clock;
  const std::function<int64_t()>& now_ms;
  std::function<void(std::shared_ptr<RunningJob>)> show;  // to readers; null: no more
  JobKeeper& keeper;
  std::stop_token stop;  // cancel or shutdown
};

class JobRun {
 public:
  JobRun(const RunContext& context, JobId id) : context_(context), id_(id) {}

  // Makes a queued job this run's. kCanceled: it is not queued any more.
  Status claim() { return move(JobState::kPreparing); }
  // After claim(), and what came of it. Runs to the job's end, to its pause, or back to the queue
  // when `stopping()` says that the server stops. What was interrupted goes on from its last
  // checkpoint.
  void run(const Status& claimed, const std::function<bool()>& stopping);

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
  std::optional<Recovery> recovery(const std::string& wanted);
  void show_film();
  Status finish(Rendered rendered);
  void end(const Error& error, const std::function<bool()>& stopping);
  void keep_partial_picture();
  void warn(std::string text);
  void log(std::string_view text);
  // Moves the state; a job that was canceled meanwhile gives kCanceled.
  Status move(JobState to, const JobStore::Change& change = {});

  RunContext context_;
  JobId id_;
  JobRecord job_;
  MemoryBudget::Part memory_;
  std::shared_ptr<const PreparedScene> scene_;
  RenderSettings settings_;
  std::optional<RenderStats> last_pass_;
  bool warm_ = false;          // started from a table
  bool mixed_builds_ = false;  // another build of qray has rendered a part
  std::shared_ptr<RunningJob> running_;
  std::vector<std::string> warnings_;
};

}  // namespace qray::server
