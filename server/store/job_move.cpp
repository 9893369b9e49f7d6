#include "server/store/job_move.h"

#include "proto/events.h"

namespace qray::server {

Result<JobMove> job_move(JobRecord job, JobState to, const JobStore::Change& change,
                         int64_t now_ms) {
  if (job.damaged || !can_move(job.state, to)) {
    return Error{ErrorCode::kConflict,
                 "the job is " + std::string(to_string(job.state)) + " and cannot become " +
                     std::string(to_string(to)),
                 ""};
  }
  // Whoever found its run dead may have queued the job again, under the same claim.
  if (change.claim && (*change.claim != job.claim || !is_running(job.state)))
    return Error{ErrorCode::kConflict, "another run has the job now", ""};
  job.state = to;
  if (change.edit) change.edit(job);
  if (has_ended(to)) job.ended_ms = now_ms;
  if (to == JobState::kPreparing) {
    job.started_ms = now_ms;
    ++job.attempts;
    ++job.claim;
  }
  if (to == JobState::kQueued) {
    job.started_ms.reset();
    job.ended_ms.reset();
  }
  JobMove move;
  move.events = change.events;
  const std::string name = job.id.text(), state(to_string(to));
  move.events.push_back(state_event_of(job));
  if (has_ended(to)) move.events.push_back({0, name, "done", proto::done_event(name, state)});
  move.log_level = job.error ? "error" : "info";
  move.log_text = state + (job.error ? ": " + job.error->text() : "");
  move.job = std::move(job);
  return move;
}

Event state_event_of(const JobRecord& job) {
  const std::string name = job.id.text();
  return {0, name, "state", proto::state_event(name, std::string(to_string(job.state)), job.error)};
}

Error not_ended(JobState state) {
  return {ErrorCode::kConflict, "the job has not ended: it is " + std::string(to_string(state)),
          ""};
}

Error key_of_another(JobId id) {
  return {ErrorCode::kConflict,
          "this Idempotency-Key was used for another request, job " + id.text(), ""};
}

Error no_job(JobId id) { return {ErrorCode::kNotFound, "no job " + id.text(), ""}; }

Error queue_is_full() {
  return {ErrorCode::kBusy, "the queue of jobs is full; try again later", ""};
}

Error table_is_named(JobId by) {
  return {ErrorCode::kConflict, "job " + by.text() + ", which has not ended, names this table", ""};
}

Error scene_is_rendered(JobId by) {
  return {ErrorCode::kConflict, "job " + by.text() + ", which has not ended, renders it", ""};
}

}  // namespace qray::server
