// One job's run, as the runner sees it: what it is told, and when it has ended.
#include <spdlog/spdlog.h>

#include "server/jobs/job_run.h"

namespace qray::server {

JobRunner::Running JobRunner::new_run(JobId id) const {
  Running running{{}, nullptr, std::make_shared<Lease>()};
  running.keeper = std::make_shared<JobKeeper>(stores_.checkpoints, id, clock_,
                                               running.cancel.get_token(), *running.lease);
  return running;
}

RunContext JobRunner::context_of(JobId id, const Running& running, TaskPool& share,
                                 std::stop_token stop) {
  const auto show = [this, id](std::shared_ptr<RunningJob> shown) {
    std::lock_guard lock(mutex_);
    running_.at(id).shown = std::move(shown);
  };
  const auto let_others_run = [this, id] {
    std::lock_guard lock(mutex_);
    if (alone_ == id && !running_.at(id).asked_alone) alone_.reset();
    ended_.notify_all();
  };
  return {stores_,
          share,
          memory_,
          clock_,
          now_ms_,
          render_,
          limits_.shared_pass_seconds,
          show,
          let_others_run,
          *running.keeper,
          *running.lease,
          running.cancel.get_token(),
          std::move(stop)};
}

void JobRunner::carry_out(JobRun& run, JobId id) {
  const auto start = clock_.seconds();
  run.run();
  {
    std::lock_guard lock(mutex_);
    running_.erase(id);
    if (alone_ == id) alone_.reset();
    ended_.notify_all();
  }
  const Result<JobRecord> ended = stores_.jobs.get(id);
  if (ended.ok()) {
    spdlog::info("job={} {} after {:.1f} s{}", id.text(), to_string(ended.value().state),
                 clock_.seconds() - start,
                 ended.value().error ? ": " + ended.value().error->message : "");
  }
}

}  // namespace qray::server
