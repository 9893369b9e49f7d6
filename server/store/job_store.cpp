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
    Result<JobRecord> job = get(id);
    if (!job.ok()) return job.error();
    if (job.value().damaged) {
      spdlog::error("job={} fails: {}", id.text(), job.value().error->text());
      if (Status s = fail_damaged(job.value()); !s.ok()) return s.error();
      continue;
    }
    const JobState state = job.value().state;
    if (state == JobState::kQueued) queued.push_back(std::move(job).value());
    if (state == JobState::kQueued || state == JobState::kPaused) continue;
    if (state == JobState::kCanceling || state == JobState::kPausing) {
      Result<JobRecord> moved =
          move(id, state == JobState::kCanceling ? JobState::kCanceled : JobState::kPaused);
      if (!moved.ok()) return moved.error();
      continue;
    }
    const bool give_up = job.value().attempts >= kMaxAttempts;
    Change change;
    change.edit = [&](JobRecord& record) {
      if (give_up) {
        record.error = proto::JobError{"the server ended " + std::to_string(kMaxAttempts) +
                                           " times while it ran this job, which got nowhere",
                                       ""};
      }
    };
    Result<JobRecord> moved = move(id, give_up ? JobState::kFailed : JobState::kQueued, change);
    if (!moved.ok()) return moved.error();
    if (!give_up) queued.push_back(std::move(moved).value());
  }
  return queued;
}

}  // namespace qray::server
