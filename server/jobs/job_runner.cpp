#include "server/jobs/job_runner.h"

#include <spdlog/spdlog.h>

#include <cmath>

#include "core/settings/frames.h"
#include "server/jobs/job_run.h"
#include "server/jobs/wait.h"
#include "server/operation/metrics.h"
#include "server/store/job_move.h"

namespace qray::server {
namespace {

constexpr std::chrono::milliseconds kWriteStates{1200};  // at a stop, which takes 2 s
constexpr double kMostJobSeconds = 24 * 3600;

Error ended(JobState state) {
  return {ErrorCode::kConflict, "the job has ended: it is " + std::string(to_string(state)), ""};
}

}  // namespace

JobRunner::JobRunner(Stores stores, const Limits& limits, const Clock& clock,
                     std::function<int64_t()> now_ms, Render render)
    : stores_(stores),
      limits_(limits),
      queue_(limits.max_queued),
      pool_(limits.threads),
      memory_(limits.memory_bytes),
      clock_(clock),
      now_ms_(std::move(now_ms)),
      render_(std::move(render)),
      submits_([this](std::span<const JobStore::Posted> posted) { return accept(posted); }) {}

void JobRunner::start(const std::vector<JobRecord>& recovered) {
  if (stores_.shared) {
    take_up_lost();
    workers_.emplace_back([this](std::stop_token stop) { keep_leases(stop); });
    for (int i = 0; i < limits_.at_once; ++i)
      workers_.emplace_back([this](std::stop_token stop) { work_shared(stop); });
    if (limits_.at_once > 0 && stores_.passes) help_others();
    return;
  }
  for (const JobRecord& job : recovered) queue_.push(job.id, job.request.get(field::kPriority));
  for (int i = 0; i < limits_.at_once; ++i)
    workers_.emplace_back([this](std::stop_token stop) { work(stop); });
}

void JobRunner::stop() {
  if (workers_.empty()) return;
  for (std::jthread& worker : workers_) worker.request_stop();
  {
    std::unique_lock lock(mutex_);
    for (auto& [id, running] : running_) running.keeper->hold();
    ended_.wait_for(lock, kWriteStates, [&] { return running_.empty(); });
    for (auto& [id, running] : running_) running.cancel.request_stop();
  }
  workers_.clear();
  if (stores_.shared) (void)stores_.shared->leave();
}

void JobRunner::work(std::stop_token stop) {
  while (const std::optional<JobId> id = queue_.pop(stop)) {
    bool told = false;
    for (;;) {
      const Status run = this->run(*id, stop);
      if (run.ok()) break;
      if (!std::exchange(told, true))
        spdlog::error("job={} cannot be run now: {}", id->text(), run.error().text());
      if (run.error().code != ErrorCode::kIo || !wait_unless(stop, kDiskAgain)) break;
    }
  }
}

bool JobRunner::may_run(JobId id, bool alone) const {
  if (running_.contains(id) || alone_) return false;  // the run before may not have left yet
  return alone ? running_.empty() : wait_to_be_alone_ == 0;
}

Status JobRunner::run(JobId id, std::stop_token stop) {
  const Result<JobRecord> record = stores_.jobs.get(id);
  if (!record.ok()) return record.error();
  const bool asked_alone = record.value().request.get(field::kAlone);
  const bool alone = asked_alone || record.value().attempts >= kMaxAttempts - 1;
  TaskPool share(pool_, std::exp2(record.value().request.get(field::kPriority)));
  Running running = new_run(id);
  running.asked_alone = asked_alone;
  JobRun job(context_of(id, running, share, stop), id);
  {
    std::unique_lock lock(mutex_);
    if (alone) ++wait_to_be_alone_;
    ended_.wait(lock, stop, [&] { return may_run(id, alone) || !is_queued(id); });
    if (alone) --wait_to_be_alone_;
    const bool claims = !stop.stop_requested() && may_run(id, alone);
    Status claimed = claims ? job.claim() : Status();
    if (claims && claimed.ok()) {
      if (alone) alone_ = id;
      running_.emplace(id, running);
    } else {
      ended_.notify_all();  // who waited for this one
      // It stays queued for the next start; or it was paused, canceled, or queued twice and claimed
      // by the other.
      if (!claims || claimed.error().code == ErrorCode::kCanceled) return {};
      return claimed;
    }
  }
  carry_out(job, id);
  return {};
}

bool JobRunner::is_queued(JobId id) const {
  const Result<JobRecord> job = stores_.jobs.get(id);
  return job.ok() && job.value().state == JobState::kQueued;
}

size_t JobRunner::places() const {
  if (!stores_.shared) return queue_.room();
  const Result<size_t> queued = stores_.shared->queued();
  if (!queued.ok()) return limits_.max_queued;  // what is asked of the store next says why
  return limits_.max_queued - std::min(queued.value(), limits_.max_queued);
}

Status JobRunner::room() const {
  if (places() > 0) return {};
  return queue_is_full();
}

Result<JobRecord> JobRunner::submit(const JobRequest& request,
                                    const std::optional<JobStore::IdempotencyKey>& key) {
  return submits_.run({request, key});
}

std::vector<Result<JobRecord>> JobRunner::accept(std::span<const JobStore::Posted> posted) {
  std::lock_guard lock(submit_mutex_);
  std::vector<Result<JobRecord>> accepted;
  for (Result<JobStore::Inserted>& one : stores_.jobs.insert(posted, places())) {
    if (!one.ok()) {
      accepted.emplace_back(one.error());
    } else if (!one.value().is_new) {
      accepted.emplace_back(std::move(one).value().job);
    } else {
      accepted.push_back(enqueue(one.value().job));
    }
  }
  return accepted;
}

Result<JobRecord> JobRunner::enqueue(const JobRecord& job) {
  const JobRequest& request = job.request;
  // From its insertion on the scene cannot be deleted; it may have been just before.
  if (!stores_.scenes.has(request.get(field::kScene))) {
    (void)stores_.jobs.move(job.id, JobState::kCanceled);
    return Error{ErrorCode::kInvalid, "the scene was deleted", "/scene"};
  }
  if (!stores_.shared) queue_.push(job.id, request.get(field::kPriority));
  spdlog::info("job={} queued: {} {}", job.id.text(), request.get(field::kScene),
               request.get(field::kMethod));
  return job;
}

Result<JobRecord> JobRunner::move_running(JobId id,
                                          const std::function<JobState(JobState)>& to_when,
                                          const std::function<void(Running&)>& tell) {
  std::lock_guard lock(mutex_);
  for (;;) {
    Result<JobRecord> job = stores_.jobs.get(id);
    if (!job.ok()) return job;
    const JobState state = job.value().state, to = to_when(state);
    if (state == to) return job;
    if (has_ended(state)) return ended(state);
    Result<JobRecord> moved = stores_.jobs.move(id, to);
    if (moved.ok() && state == JobState::kQueued) {
      queue_.remove(id);  // if a worker has it already, it cannot claim it
      ended_.notify_all();
    } else if (const auto found = running_.find(id); moved.ok() && found != running_.end()) {
      tell(found->second);
    }
    if (moved.ok() || moved.error().code != ErrorCode::kConflict) return moved;
    // Its state changed since it was read, or it cannot become that from this one.
    const Result<JobRecord> now = stores_.jobs.get(id);
    if (!now.ok() || now.value().state == state) return moved;
  }
}

Result<JobRecord> JobRunner::cancel(JobId id) {
  const auto to_when = [](JobState state) {
    return state == JobState::kQueued || state == JobState::kPaused ? JobState::kCanceled
                                                                    : JobState::kCanceling;
  };
  Result<JobRecord> job =
      move_running(id, to_when, [](Running& running) { running.cancel.request_stop(); });
  if (job.ok() && job.value().state == JobState::kCanceled) {
    stores_.checkpoints.remove(id);
    if (stores_.metrics) stores_.metrics->add_end(to_string(JobState::kCanceled));
  }
  return job;
}

Result<JobRecord> JobRunner::pause(JobId id) {
  const auto to_when = [](JobState state) {
    return state == JobState::kQueued || state == JobState::kPaused ? JobState::kPaused
                                                                    : JobState::kPausing;
  };
  return move_running(id, to_when, [](Running& running) {
    running.keeper->hold();
    if (!running.shown) running.cancel.request_stop();  // while its scene is loaded
  });
}

Result<JobRecord> JobRunner::resume(JobId id) {
  std::lock_guard lock(submit_mutex_);
  Result<JobRecord> job = stores_.jobs.get(id);
  if (!job.ok()) return job;
  if (job.value().state != JobState::kPaused)
    return Error{ErrorCode::kConflict,
                 "the job is not paused: it is " + std::string(to_string(job.value().state)), ""};
  if (Status s = room(); !s.ok()) return s.error();
  return queue_again(id, {});
}

// A job that can go on after its end, where the queue has room for it.
Result<JobRecord> JobRunner::extendable(JobId id) const {
  Result<JobRecord> job = stores_.jobs.get(id);
  if (!job.ok()) return job;
  if (job.value().state != JobState::kSucceeded)
    return Error{ErrorCode::kConflict,
                 "the job has not succeeded: it is " + std::string(to_string(job.value().state)),
                 ""};
  if (!stores_.checkpoints.has(id))
    return Error{ErrorCode::kConflict,
                 "what the job would go on from is not kept any more: post it anew", ""};
  if (Status s = room(); !s.ok()) return s.error();
  return job;
}

Result<JobRecord> JobRunner::go_on(JobId id) {
  std::lock_guard lock(submit_mutex_);
  if (const Result<JobRecord> job = extendable(id); !job.ok()) return job.error();
  JobStore::Change change;
  change.edit = [](JobRecord& record) {
    record.progress.fraction = 0;
    record.attempts = 0;
  };
  return queue_again(id, change);
}

Result<JobRecord> JobRunner::extend(JobId id, const proto::ExtendRequest& more) {
  std::lock_guard lock(submit_mutex_);
  const Result<JobRecord> job = extendable(id);
  if (!job.ok()) return job;
  JobRequest request = job.value().request;
  const proto::JobProgress& done = job.value().progress;
  // Onto what was rendered: the limits that stood before have been reached.
  const int64_t samples = static_cast<int64_t>(done.samples) + more.samples.value_or(0);
  // Frames share it: a request names the seconds of each.
  const double seconds =
      (done.seconds + more.seconds.value_or(0)) / frame_count(request).value_or(1);
  if (samples > kMaxSamples || seconds > kMostJobSeconds)
    return Error{ErrorCode::kInvalid, "a job has at most 1000000 samples a pixel and 24 h",
                 more.samples ? "/samples" : "/seconds"};
  request.clear(field::kSamples);
  request.clear(field::kSeconds);
  if (more.samples) request.set(field::kSamples, static_cast<int>(samples));
  if (more.seconds) request.set(field::kSeconds, seconds);
  request.clear(field::kNoise);
  if (more.noise) request.set(field::kNoise, *more.noise);
  JobStore::Change change;
  change.edit = [&](JobRecord& record) {
    record.request = request;
    record.progress.fraction = 0;
    record.attempts = 0;
  };
  return queue_again(id, change);
}

Result<JobRecord> JobRunner::update(JobId id, const proto::JobUpdate& update) {
  std::lock_guard submit_lock(submit_mutex_);  // an extension writes the whole request
  std::lock_guard lock(mutex_);
  Result<JobRecord> job = stores_.jobs.update(id, [&](JobRequest& request) {
    if (update.labels) request.clear(field::kLabels);
    if (update.labels && !update.labels->empty()) request.set(field::kLabels, *update.labels);
    if (update.priority) request.set(field::kPriority, *update.priority);
  });
  if (job.ok() && update.priority) queue_.set_priority(id, *update.priority);
  return job;
}

Result<JobRecord> JobRunner::queue_again(JobId id, const JobStore::Change& change) {
  std::lock_guard lock(mutex_);
  Result<JobRecord> job = stores_.jobs.move(id, JobState::kQueued, change);
  if (job.ok() && !stores_.shared) queue_.push(id, job.value().request.get(field::kPriority));
  return job;
}

Status JobRunner::remove(JobId id) {
  std::lock_guard lock(submit_mutex_);
  if (Status s = stores_.jobs.remove(id); !s.ok()) return s;
  stores_.checkpoints.remove(id);
  stores_.moments.remove(id);
  stores_.results.remove(id);
  return {};
}

std::shared_ptr<const RunningJob> JobRunner::running(JobId id) const {
  std::lock_guard lock(mutex_);
  const auto found = running_.find(id);
  return found == running_.end() ? nullptr : found->second.shown;
}

}  // namespace qray::server
