#include "server/store/job_store.h"

#include <spdlog/spdlog.h>

namespace qray::server {

Result<JobRecord> JobStore::find(const std::string& id) const {
  const std::optional<JobId> parsed = JobId::parse(id);
  if (!parsed) return Error{ErrorCode::kNotFound, "no such job", ""};
  return get(*parsed);
}

Result<std::vector<JobRecord>> JobStore::recover() {
  if (Status s = restore_events(); !s.ok()) return s.error();
  const Result<std::vector<JobId>> open = this->open();
  if (!open.ok()) return open.error();
  std::vector<JobRecord> queued;
  for (const JobId id : open.value()) {
    Result<std::optional<JobRecord>> job = take_up(id);
    if (!job.ok()) return job.error();
    if (job.value()) queued.push_back(*std::move(job).value());
  }
  return queued;
}

Result<std::optional<JobRecord>> JobStore::take_up(JobId id) {
  const std::optional<JobRecord> none;
  Result<JobRecord> job = get(id);
  if (!job.ok()) return job.error();
  if (job.value().damaged) {
    spdlog::error("job={} fails: {}", id.text(), job.value().error->text());
    if (Status s = fail_damaged(job.value()); !s.ok()) return s.error();
    return none;
  }
  const JobState state = job.value().state;
  if (state == JobState::kQueued) return std::optional(std::move(job).value());
  if (!is_running(state)) return none;
  Change change;
  change.claim = job.value().claim;
  if (state == JobState::kCanceling || state == JobState::kPausing) {
    Result<JobRecord> moved =
        move(id, state == JobState::kCanceling ? JobState::kCanceled : JobState::kPaused, change);
    if (!moved.ok()) return moved.error();
    return none;
  }
  const bool give_up = job.value().attempts >= kMaxAttempts;
  change.edit = [&](JobRecord& record) {
    if (give_up) {
      record.error = proto::JobError{"the server ended " + std::to_string(kMaxAttempts) +
                                         " times while it ran this job, which got nowhere",
                                     ""};
    }
  };
  Result<JobRecord> moved = move(id, give_up ? JobState::kFailed : JobState::kQueued, change);
  if (!moved.ok()) return moved.error();
  if (give_up) return none;
  return std::optional(std::move(moved).value());
}

}  // namespace qray::server
