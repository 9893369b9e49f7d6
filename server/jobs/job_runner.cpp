#include "server/jobs/job_runner.h"

#include <spdlog/spdlog.h>

#include "server/jobs/job_run.h"

namespace qray::server {

JobRunner::JobRunner(Stores stores, int threads, size_t max_queued, const Clock& clock,
                     std::function<int64_t()> now_ms)
    : stores_(stores),
      queue_(max_queued),
      pool_(threads),
      clock_(clock),
      now_ms_(std::move(now_ms)) {}

void JobRunner::start(const std::vector<JobId>& recovered) {
  for (JobId id : recovered) (void)queue_.push(id, /*keep_bound=*/false);
  worker_ = std::jthread([this](std::stop_token stop) { work(stop); });
}

void JobRunner::stop() {
  if (!worker_.joinable()) return;
  worker_.request_stop();
  {
    std::lock_guard lock(mutex_);
    cancel_running_.request_stop();
  }
  worker_.join();
}

void JobRunner::work(std::stop_token stop) {
  while (const std::optional<JobId> id = queue_.pop(stop)) {
    std::stop_token cancel;
    {
      std::lock_guard lock(mutex_);
      running_ = *id;
      cancel_running_ = std::stop_source();
      if (stop.stop_requested()) cancel_running_.request_stop();
      cancel = cancel_running_.get_token();
    }
    const auto show = [this](std::shared_ptr<LiveJob> live) {
      std::lock_guard lock(mutex_);
      live_ = std::move(live);
    };
    const auto start = clock_.seconds();
    JobRun({stores_, pool_, clock_, now_ms_, show, cancel}, *id).run([&] {
      return stop.stop_requested();
    });
    {
      std::lock_guard lock(mutex_);
      running_ = {};
    }
    const Result<JobRecord> job = stores_.jobs.get(*id);
    if (job.ok()) {
      spdlog::info("job={} {} after {:.1f} s{}", id->text(), to_string(job.value().state),
                   clock_.seconds() - start,
                   job.value().error ? ": " + job.value().error->message : "");
    }
  }
}

Result<JobRecord> JobRunner::submit(const proto::JobRequest& request) {
  std::lock_guard lock(submit_mutex_);
  if (queue_.full()) {
    return Error{ErrorCode::kBusy, "the queue of jobs is full; try again later", ""};
  }
  Result<JobRecord> job = stores_.jobs.insert(request);
  if (!job.ok()) return job;
  // From the insertion on it cannot be deleted; it may have been just before.
  if (!stores_.scenes.has(request.scene)) {
    (void)stores_.jobs.move(job.value().id, JobState::kCanceled);
    return Error{ErrorCode::kInvalid, "the scene was deleted", "/scene"};
  }
  if (Status s = queue_.push(job.value().id); !s.ok()) return s.error();
  spdlog::info("job={} queued: {} {}", job.value().id.text(), request.scene, request.method);
  return job;
}

Result<JobRecord> JobRunner::cancel(JobId id) {
  if (queue_.remove(id)) return stores_.jobs.move(id, JobState::kCanceled);
  std::lock_guard lock(mutex_);
  for (;;) {
    Result<JobRecord> job = stores_.jobs.get(id);
    if (!job.ok() || job.value().state == JobState::kCanceling) return job;
    if (has_ended(job.value().state)) {
      return Error{ErrorCode::kConflict,
                   "the job has ended: it is " + std::string(to_string(job.value().state)), ""};
    }
    // Taken from the queue, but not preparing yet: it never will.
    const bool waits = job.value().state == JobState::kQueued;
    Result<JobRecord> moved =
        stores_.jobs.move(id, waits ? JobState::kCanceled : JobState::kCanceling);
    if (moved.ok() && running_ == id) cancel_running_.request_stop();
    // A conflict: its state changed since it was read. States only go forward, so this ends.
    if (moved.ok() || moved.error().code != ErrorCode::kConflict) return moved;
  }
}

std::shared_ptr<const LiveJob> JobRunner::live(JobId id) const {
  std::lock_guard lock(mutex_);
  return live_ && live_->id() == id ? live_ : nullptr;
}

}  // namespace qray::server
