#include "server/sqlite/sqlite_job_store.h"

#include <spdlog/spdlog.h>

#include <algorithm>

#include "proto/events.h"
#include "server/model/lines.h"
#include "server/sqlite/job_row.h"
#include "server/sqlite/sqlite_table_index.h"
#include "server/sqlite/sqlite_webhook_store.h"
#include "server/store/job_move.h"

namespace qray::server {

Status SqliteJobStore::write(Database::Session& session, const JobRecord& job) {
  std::optional<std::string> message, where;
  if (job.error) {
    message = job.error->message;
    where = job.error->where;
  }
  return Query(session.handle(),
               "UPDATE jobs SET state=?, request=?, started_ms=?, ended_ms=?, fraction=?, "
               "samples=?, seconds=?, error_message=?, error_where=?, table_in=?, table_out=?, "
               "stats=?, biased=?, warnings=?, attempts=?, claim=? WHERE id=?")
      .bind(std::string(to_string(job.state)))
      .bind(proto::job_request_to_json(job.request))
      .bind(job.started_ms)
      .bind(job.ended_ms)
      .bind(job.progress.fraction)
      .bind(job.progress.samples)
      .bind(job.progress.seconds)
      .bind(message)
      .bind(where)
      .bind(job.table_in)
      .bind(job.table_out)
      .bind(job.stats_json)
      .bind(job.biased ? 1 : 0)
      .bind(join_lines(job.warnings))
      .bind(job.attempts)
      .bind(job.claim)
      .bind(job.id.value)
      .run();
}

Status SqliteJobStore::write_log(Database::Session& session, JobId id, std::string_view level,
                                 std::string_view text) {
  Status written =
      Query(session.handle(), "INSERT INTO job_log(job, time_ms, level, text) VALUES(?,?,?,?)")
          .bind(id.value)
          .bind(now_ms_())
          .bind(std::string(level))
          .bind(std::string(text))
          .run();
  if (!written.ok()) return written;
  return Query(session.handle(),
               "DELETE FROM job_log WHERE job=?1 AND id <= (SELECT id FROM job_log WHERE job=?1 "
               "ORDER BY id DESC LIMIT 1 OFFSET ?2)")
      .bind(id.value)
      .bind(kLogLines)
      .run();
}

void SqliteJobStore::log(JobId id, std::string_view level, std::string_view text) {
  Database::Session session(db_);
  if (Status s = write_log(session, id, level, text); !s.ok())
    spdlog::error("job={} its log: {}", id.text(), s.error().text());
}

Result<std::vector<SqliteJobStore::LogLine>> SqliteJobStore::log_of(JobId id) const {
  const Database::Reading session(db_);
  Query query(session.handle(), "SELECT time_ms, level, text FROM job_log WHERE job=? ORDER BY id");
  query.bind(id.value);
  std::vector<LogLine> lines;
  while (query.next()) lines.push_back({query.integer(0), query.text(1), query.text(2)});
  if (Status s = query.status(); !s.ok()) return s.error();
  return lines;
}

Result<JobRecord> SqliteJobStore::get(JobId id) const {
  const Database::Reading reading(db_);
  return read(reading.handle(), id);
}

Result<JobRecord> SqliteJobStore::read(sqlite3* db, JobId id) const {
  const std::string sql = std::string("SELECT ") + kJobColumns + " FROM jobs WHERE id=?";
  Query query(db, sql.c_str());
  query.bind(id.value);
  if (query.next()) return read_job(query);
  if (Status s = query.status(); !s.ok()) return s.error();
  return no_job(id);
}

Result<std::vector<JobId>> SqliteJobStore::ended_before(int64_t ms, size_t limit) const {
  const Database::Reading session(db_);
  Query query(session.handle(),
              "SELECT id FROM jobs WHERE state IN ('succeeded','canceled','failed') AND ended_ms<? "
              "ORDER BY id LIMIT ?");
  query.bind(ms).bind(static_cast<int64_t>(limit));
  std::vector<JobId> ids;
  while (query.next()) ids.push_back({static_cast<uint64_t>(query.integer(0))});
  if (Status s = query.status(); !s.ok()) return s.error();
  return ids;
}

Result<SqliteJobStore::Ids> SqliteJobStore::ids() const {
  const Database::Reading reading(db_);
  Ids ids;
  Query there(reading.handle(), "SELECT id FROM jobs ORDER BY id");
  while (there.next()) ids.there.push_back({static_cast<uint64_t>(there.integer(0))});
  if (Status s = there.status(); !s.ok()) return s.error();
  Query newest(reading.handle(), "SELECT seq FROM sqlite_sequence WHERE name='jobs'");
  if (newest.next()) ids.newest.value = static_cast<uint64_t>(newest.integer(0));
  if (Status s = newest.status(); !s.ok()) return s.error();
  return ids;
}

Status SqliteJobStore::give_no_id_up_to(JobId id) {
  Database::Transaction transaction(db_);
  if (Status s = transaction.exec("DELETE FROM sqlite_sequence WHERE name='jobs'"); !s.ok())
    return s;
  Query raised(transaction.handle(), "INSERT INTO sqlite_sequence(name, seq) VALUES('jobs', ?)");
  if (Status s = raised.bind(id.value).run(); !s.ok()) return s;
  return transaction.commit();
}

Result<SqliteJobStore::Counts> SqliteJobStore::count() const {
  Counts counts;
  const Database::Reading session(db_);
  Query states(session.handle(), "SELECT state, COUNT(*) FROM jobs GROUP BY state");
  while (states.next())
    if (const auto state = parse_job_state(states.text(0)))
      counts.by_state[*state] = static_cast<uint64_t>(states.integer(1));
  if (Status s = states.status(); !s.ok()) return s.error();
  Query oldest(session.handle(), "SELECT MIN(created_ms) FROM jobs WHERE state='queued'");
  if (oldest.next() && !oldest.is_null(0)) counts.oldest_queued_ms = oldest.integer(0);
  if (Status s = oldest.status(); !s.ok()) return s.error();
  return counts;
}

Status SqliteJobStore::remove(JobId id) {
  Database::Session session(db_);
  if (Status s = prepare_events(); !s.ok()) return s;
  Database::Transaction transaction(db_);
  const Result<JobRecord> job = read(transaction.handle(), id);
  if (!job.ok()) return job.error();
  if (!has_ended(job.value().state)) return not_ended(job.value().state);
  for (const char* sql : {"DELETE FROM jobs WHERE id=?", "DELETE FROM job_log WHERE job=?",
                          "DELETE FROM idempotency_keys WHERE job=?"})
    if (Status s = Query(transaction.handle(), sql).bind(id.value).run(); !s.ok()) return s;
  if (Status s =
          Query(transaction.handle(), "DELETE FROM events WHERE job=?").bind(id.text()).run();
      !s.ok())
    return s;
  Event event{0, id.text(), "deleted", proto::deleted_event(id.text())};
  if (Status s = write_event(transaction, event); !s.ok()) return s;
  if (Status s = transaction.commit(); !s.ok()) return s;
  events_.publish(std::move(event));
  return {};
}

Status SqliteJobStore::reset_attempts(JobId id) {
  Database::Session session(db_);
  return Query(session.handle(), "UPDATE jobs SET attempts=0 WHERE id=?").bind(id.value).run();
}

Status SqliteJobStore::remove_scene(const std::string& scene,
                                    const std::function<Status()>& remove) const {
  Database::Session session(db_);
  Query user(session.handle(),
             "SELECT id FROM jobs WHERE state NOT IN ('succeeded','canceled','failed') AND "
             "json_valid(request) AND json_extract(request, '$.scene')=? LIMIT 1");
  user.bind(scene);
  if (user.next()) return scene_is_rendered({static_cast<uint64_t>(user.integer(0))});
  if (Status s = user.status(); !s.ok()) return s;
  return remove();
}

Result<JobRecord> SqliteJobStore::update(JobId id, const std::function<void(JobRequest&)>& edit) {
  Database::Transaction transaction(db_);
  Result<JobRecord> job = read(transaction.handle(), id);
  if (!job.ok()) return job;
  if (job.value().damaged) return Error{ErrorCode::kConflict, job.value().error->message, ""};
  edit(job.value().request);
  if (Status s = write(transaction, job.value()); !s.ok()) return s.error();
  if (Status s = transaction.commit(); !s.ok()) return s.error();
  return job;
}

Result<JobRecord> SqliteJobStore::move(JobId id, JobState to, const Change& change) {
  Database::Session session(db_);
  if (Status s = prepare_events(); !s.ok()) return s.error();
  Database::Transaction transaction(db_);
  Result<JobRecord> found = read(transaction.handle(), id);
  if (!found.ok()) return found.error();
  Result<JobMove> made = job_move(std::move(found).value(), to, change, now_ms_());
  if (!made.ok()) return made.error();
  JobMove& move = made.value();
  if (Status s = write(transaction, move.job); !s.ok()) return s.error();
  if (Status s = write_log(transaction, id, move.log_level, move.log_text); !s.ok())
    return s.error();
  for (Event& event : move.events) {
    if (Status s = write_event(transaction, event); !s.ok()) return s.error();
  }
  if (change.table)
    if (Status s = SqliteTableIndex::record(transaction, *change.table); !s.ok()) return s.error();
  if (has_ended(to))
    if (Status s = SqliteWebhookStore::tell(transaction, id, now_ms_()); !s.ok()) return s.error();
  if (Status s = transaction.commit(); !s.ok()) return s.error();
  for (Event& event : move.events) events_.publish(std::move(event));
  return std::move(move.job);
}

Result<std::vector<JobId>> SqliteJobStore::open() const {
  const Database::Reading reading(db_);
  Query query(reading.handle(),
              "SELECT id FROM jobs WHERE state NOT IN ('succeeded','canceled','failed') "
              "ORDER BY id");
  std::vector<JobId> ids;
  while (query.next()) ids.push_back({static_cast<uint64_t>(query.integer(0))});
  if (Status s = query.status(); !s.ok()) return s.error();
  return ids;
}

Status SqliteJobStore::fail_damaged(const JobRecord& job) {
  Database::Session session(db_);
  return Query(session.handle(),
               "UPDATE jobs SET state='failed', ended_ms=?, error_message=?, error_where='' WHERE "
               "id=?")
      .bind(now_ms_())
      .bind(job.error->message)
      .bind(job.id.value)
      .run();
}

Status SqliteJobStore::try_writing() {
  Database::Transaction transaction(db_);
  Query write(transaction.handle(), "INSERT OR REPLACE INTO counters VALUES ('looked_ms', ?)");
  if (Status s = write.bind(now_ms_()).run(); !s.ok()) return s;
  return transaction.commit();
}

}  // namespace qray::server
