#include "server/postgres/pg_job_row.h"

#include "server/model/lines.h"

namespace qray::server {

JobRecord read_pg_job(const PgRows& rows, int row) {
  JobRecord job;
  job.id.value = rows.number(row, 0);
  std::string damage;
  const std::optional<JobState> state = parse_job_state(rows.text(row, 1));
  if (!state) damage = "unknown state " + rows.text(row, 1);
  auto request = proto::parse_stored_request(rows.text(row, 2));
  if (const auto* problem = std::get_if<proto::Problem>(&request)) {
    damage = "stored request: " + problem->detail;
  } else {
    job.request = std::get<JobRequest>(std::move(request));
  }
  job.created_ms = rows.integer(row, 3);
  if (!rows.is_null(row, 4)) job.started_ms = rows.integer(row, 4);
  if (!rows.is_null(row, 5)) job.ended_ms = rows.integer(row, 5);
  job.progress = {rows.real(row, 6), rows.number(row, 7), rows.real(row, 8)};
  if (!rows.is_null(row, 9)) job.error = proto::JobError{rows.text(row, 9), rows.text(row, 10)};
  job.table_in = rows.text(row, 11);
  job.table_out = rows.text(row, 12);
  job.stats_json = rows.text(row, 13);
  job.biased = rows.text(row, 14) == "t";
  job.warnings = split_lines(rows.text(row, 15));
  job.attempts = static_cast<int>(rows.integer(row, 16));
  job.claim = rows.number(row, 17);
  job.state = state.value_or(JobState::kFailed);
  if (!damage.empty()) {
    job.damaged = true;
    if (!job.request.given(field::kScene)) job.request.set(field::kScene, "unknown");
    job.state = JobState::kFailed;
    job.error = proto::JobError{"the job's record is damaged: " + damage, ""};
  }
  return job;
}

std::vector<JobId> pg_ids(const PgRows& rows) {
  std::vector<JobId> ids;
  for (int row = 0; row < rows.size(); ++row) ids.push_back({rows.number(row, 0)});
  return ids;
}

int64_t pg_rank(const JobRecord& job) {
  constexpr int64_t kMsAStep = 60'000;
  return job.created_ms - kMsAStep * job.request.get(field::kPriority);
}

}  // namespace qray::server
