#include "server/sqlite/job_row.h"

#include "server/model/lines.h"

namespace qray::server {
namespace {

Result<JobRequest> stored_request(const std::string& json) {
  auto parsed = proto::parse_stored_request(json);
  if (const auto* problem = std::get_if<proto::Problem>(&parsed)) {
    return Error{ErrorCode::kCorrupt, "stored request: " + problem->detail, ""};
  }
  return std::get<JobRequest>(std::move(parsed));
}

}  // namespace

JobRecord read_job(const Query& row) {
  JobRecord job;
  job.id.value = static_cast<uint64_t>(row.integer(0));
  std::string damage;
  const std::optional<JobState> state = parse_job_state(row.text(1));
  if (!state) damage = "unknown state " + row.text(1);
  Result<JobRequest> request = stored_request(row.text(2));
  if (!request.ok()) damage = request.error().message;
  if (request.ok()) job.request = std::move(request).value();
  job.created_ms = row.integer(3);
  if (!row.is_null(4)) job.started_ms = row.integer(4);
  if (!row.is_null(5)) job.ended_ms = row.integer(5);
  job.progress = {row.real(6), static_cast<uint64_t>(row.integer(7)), row.real(8)};
  if (!row.is_null(9)) job.error = proto::JobError{row.text(9), row.text(10)};
  job.table_in = row.text(11);
  job.table_out = row.text(12);
  job.stats_json = row.text(13);
  job.biased = row.integer(14) != 0;
  job.warnings = split_lines(row.text(15));
  job.attempts = static_cast<int>(row.integer(16));
  job.claim = static_cast<uint64_t>(row.integer(17));
  job.state = state.value_or(JobState::kFailed);
  if (!damage.empty()) {
    job.damaged = true;
    if (!job.request.given(field::kScene)) job.request.set(field::kScene, "unknown");
    job.state = JobState::kFailed;
    job.error = proto::JobError{"the job's record is damaged: " + damage, ""};
  }
  return job;
}

}  // namespace qray::server
