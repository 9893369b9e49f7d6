#include "server/postgres/pg_job_store.h"

#include <spdlog/spdlog.h>

#include "proto/events.h"
#include "server/model/lines.h"
#include "server/postgres/pg_job_row.h"
#include "server/postgres/pg_table_index.h"
#include "server/postgres/pg_webhook_store.h"

namespace qray::server {

Result<JobRecord> PgJobStore::get(JobId id) const {
  PgDatabase::Session session(db_);
  const Result<PgRows> rows = session.run(
      std::string("SELECT ") + kPgJobColumns + " FROM " + kPgJobTables + " WHERE jobs.id=$1",
      {id.value});
  if (!rows.ok()) return rows.error();
  if (rows.value().empty()) return no_job(id);
  return read_pg_job(rows.value(), 0);
}

Result<JobRecord> PgJobStore::read_locked(Transaction& transaction, JobId id) {
  const Result<PgRows> rows =
      transaction.run(std::string("SELECT ") + kPgJobColumns + " FROM " + kPgJobTables +
                          " WHERE jobs.id=$1 FOR UPDATE OF jobs",
                      {id.value});
  if (!rows.ok()) return rows.error();
  if (rows.value().empty()) return no_job(id);
  return read_pg_job(rows.value(), 0);
}

Status PgJobStore::write(Transaction& transaction, const JobRecord& job) {
  std::optional<std::string> message, where;
  if (job.error) {
    message = job.error->message;
    where = job.error->where;
  }
  return transaction.change(
      "UPDATE jobs SET state=$2, request=$3::text, "
      "labels=coalesce(($3::text::json->'labels')::jsonb, '{}'), "
      "scene=$4, wanted_table=$5, rank=$6, started_ms=$7, ended_ms=$8, fraction=$9, samples=$10, "
      "seconds=$11, error_message=$12, error_where=$13, table_in=$14, table_out=$15, stats=$16, "
      "biased=$17, warnings=$18, attempts=$19, claim=$20 WHERE id=$1",
      {job.id.value,
       to_string(job.state),
       proto::job_request_to_json(job.request),
       job.request.get(field::kScene),
       job.request.get(field::kTable),
       pg_rank(job),
       job.started_ms,
       job.ended_ms,
       job.progress.fraction,
       job.progress.samples,
       job.progress.seconds,
       message,
       where,
       job.table_in,
       job.table_out,
       job.stats_json,
       job.biased,
       join_lines(job.warnings),
       job.attempts,
       job.claim});
}

Status PgJobStore::write_log(PgDatabase::Session& session, JobId id, std::string_view level,
                             std::string_view text) {
  const Result<PgRows> written =
      session.run("INSERT INTO job_log(job, time_ms, level, text) VALUES($1,$2,$3,$4)",
                  {id.value, now_ms_(), level, text});
  if (!written.ok()) return written.error();
  const Result<PgRows> cut = session.run(
      "DELETE FROM job_log WHERE job=$1 AND id <= (SELECT id FROM job_log WHERE job=$1 "
      "ORDER BY id DESC LIMIT 1 OFFSET $2)",
      {id.value, kLogLines});
  return cut.ok() ? Status() : Status(cut.error());
}

void PgJobStore::log(JobId id, std::string_view level, std::string_view text) {
  PgDatabase::Session session(db_);
  if (Status s = write_log(session, id, level, text); !s.ok())
    spdlog::error("job={} its log: {}", id.text(), s.error().text());
}

Result<std::vector<PgJobStore::LogLine>> PgJobStore::log_of(JobId id) const {
  PgDatabase::Session session(db_);
  const Result<PgRows> rows =
      session.run("SELECT time_ms, level, text FROM job_log WHERE job=$1 ORDER BY id", {id.value});
  if (!rows.ok()) return rows.error();
  std::vector<LogLine> lines;
  for (int row = 0; row < rows.value().size(); ++row)
    lines.push_back(
        {rows.value().integer(row, 0), rows.value().text(row, 1), rows.value().text(row, 2)});
  return lines;
}

Status PgJobStore::remove(JobId id) {
  {
    Transaction transaction(db_);
    const Result<JobRecord> job = read_locked(transaction, id);
    if (!job.ok()) return job.error();
    if (!has_ended(job.value().state)) return not_ended(job.value().state);
    for (const char* sql : {"DELETE FROM jobs WHERE id=$1", "DELETE FROM job_log WHERE job=$1",
                            "DELETE FROM idempotency_keys WHERE job=$1"})
      if (Status s = transaction.change(sql, {id.value}); !s.ok()) return s;
    for (const char* sql :
         {"DELETE FROM new_events WHERE job=$1", "DELETE FROM events WHERE job=$1"})
      if (Status s = transaction.change(sql, {id.text()}); !s.ok()) return s;
    if (Status s =
            write_event(transaction, {0, id.text(), "deleted", proto::deleted_event(id.text())});
        !s.ok())
      return s;
    if (Status s = transaction.commit(); !s.ok()) return s;
  }
  publish_new();
  return {};
}

Status PgJobStore::reset_attempts(JobId id) {
  Transaction transaction(db_);
  if (Status s = transaction.change("UPDATE jobs SET attempts=0 WHERE id=$1", {id.value}); !s.ok())
    return s;
  return transaction.commit();
}

// Who inserts jobs holds the same lock, shared.
Status PgJobStore::remove_scene(const std::string& scene,
                                const std::function<Status()>& remove) const {
  Transaction transaction(db_);
  if (Status s = transaction.change("SELECT pg_advisory_xact_lock(hashtext('qray scenes'))");
      !s.ok())
    return s;
  const Result<PgRows> user = transaction.run(
      "SELECT id FROM jobs WHERE state NOT IN ('succeeded','canceled','failed') AND scene=$1 "
      "LIMIT 1",
      {scene});
  if (!user.ok()) return user.error();
  if (!user.value().empty()) return scene_is_rendered({user.value().number(0, 0)});
  return remove();
}

Result<JobRecord> PgJobStore::update(JobId id, const std::function<void(JobRequest&)>& edit) {
  Transaction transaction(db_);
  Result<JobRecord> job = read_locked(transaction, id);
  if (!job.ok()) return job;
  if (job.value().damaged) return Error{ErrorCode::kConflict, job.value().error->message, ""};
  edit(job.value().request);
  if (Status s = write(transaction, job.value()); !s.ok()) return s.error();
  if (Status s = transaction.commit(); !s.ok()) return s.error();
  return job;
}

Result<JobRecord> PgJobStore::move(JobId id, JobState to, const Change& change) {
  Result<JobMove> made = Error{};
  {
    Transaction transaction(db_);
    Result<JobRecord> found = read_locked(transaction, id);
    if (!found.ok()) return found.error();
    made = job_move(std::move(found).value(), to, change, now_ms_());
    if (!made.ok()) return made.error();
    const JobMove& move = made.value();
    if (Status s = write(transaction, move.job); !s.ok()) return s.error();
    if (Status s = write_run(transaction, move.job); !s.ok()) return s.error();
    if (Status s = write_log(transaction, id, move.log_level, move.log_text); !s.ok())
      return s.error();
    for (const Event& event : move.events)
      if (Status s = write_event(transaction, event); !s.ok()) return s.error();
    if (change.table)
      if (Status s = PgTableIndex::record(transaction, *change.table); !s.ok()) return s.error();
    if (has_ended(to))
      if (Status s = PgWebhookStore::tell(transaction, id, now_ms_()); !s.ok()) return s.error();
    if (Status s = transaction.commit(); !s.ok()) return s.error();
  }
  if (to == JobState::kQueued || to == JobState::kCanceling || to == JobState::kPausing)
    tell_others();
  publish_new();
  return std::move(made.value().job);
}

Status PgJobStore::fail_damaged(const JobRecord& job) {
  Transaction transaction(db_);
  if (Status s = transaction.change("UPDATE jobs SET state='failed', ended_ms=$2, "
                                    "error_message=$3, error_where='' WHERE id=$1",
                                    {job.id.value, now_ms_(), job.error->message});
      !s.ok())
    return s;
  if (Status s = transaction.change("DELETE FROM runs WHERE job=$1", {job.id.value}); !s.ok())
    return s;
  return transaction.commit();
}

Status PgJobStore::try_writing() {
  Transaction transaction(db_);
  if (Status s = transaction.change(
          "INSERT INTO looked VALUES(1, $1) ON CONFLICT(one) DO UPDATE SET time_ms=$1",
          {now_ms_()});
      !s.ok())
    return s;
  return transaction.commit();
}

}  // namespace qray::server
