#include "server/sqlite/sqlite_job_store.h"

#include <spdlog/spdlog.h>

#include <algorithm>

#include "proto/events.h"
#include "server/sqlite/job_row.h"
#include "server/sqlite/lines.h"
#include "server/sqlite/sqlite_table_index.h"

namespace qray::server {
namespace {

constexpr uint64_t kIdBlock = 10'000;         // event ids reserved by one write
constexpr int64_t kEventsKept = 2'000;        // on disk, at a start
constexpr size_t kMostHints = 1000;           // that wait for a writer
constexpr int64_t kKeyMs = 24 * 3600 * 1000;  // that a key is known

}  // namespace

Status SqliteJobStore::prepare_events(uint64_t at_least) {
  Database::Session session(db_);
  std::vector<Event> hints;
  {
    std::lock_guard lock(hints_mutex_);
    hints.swap(hints_);
  }
  at_least += hints.size();
  if (Status s = reserve_event_ids(at_least); !s.ok()) return s;
  for (Event& hint : hints) {
    hint.id = ++last_event_id_;
    events_.publish(std::move(hint));
  }
  return {};
}

Status SqliteJobStore::reserve_event_ids(uint64_t at_least) {
  if (last_event_id_ + at_least <= reserved_up_to_) return {};
  Database::Session session(db_);
  Query query(session.handle(),
              "INSERT INTO counters VALUES('event', ?1) "
              "ON CONFLICT(name) DO UPDATE SET value = ?1");
  query.bind(reserved_up_to_ + kIdBlock);
  if (Status s = query.run(); !s.ok()) return s;
  reserved_up_to_ += kIdBlock;
  return {};
}

Status SqliteJobStore::write_event(Database::Session& session, Event& event) {
  event.id = ++last_event_id_;
  return Query(session.handle(), "INSERT INTO events VALUES(?,?,?,?)")
      .bind(event.id)
      .bind(event.job)
      .bind(event.kind)
      .bind(event.data)
      .run();
}

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

Result<std::optional<JobRecord>> SqliteJobStore::find_key(const IdempotencyKey& key) const {
  Database::Session session(db_);
  Query query(session.handle(),
              "SELECT job, request FROM idempotency_keys WHERE key=? AND created_ms>?");
  query.bind(key.key).bind(now_ms_() - kKeyMs);
  if (!query.next()) {
    if (Status s = query.status(); !s.ok()) return s.error();
    return std::optional<JobRecord>();
  }
  const JobId id{static_cast<uint64_t>(query.integer(0))};
  if (query.text(1) != key.request)
    return Error{ErrorCode::kConflict,
                 "this Idempotency-Key was used for another request, job " + id.text(), ""};
  Result<JobRecord> job = read(session.handle(), id);
  if (!job.ok()) return job.error();
  return std::optional(std::move(job).value());
}

std::vector<Result<SqliteJobStore::Inserted>> SqliteJobStore::insert(std::span<const Posted> posted,
                                                                     size_t room) {
  Database::Session session(db_);
  const auto all_refused = [&](const Error& error) {
    return std::vector<Result<Inserted>>(posted.size(), error);
  };
  if (Status s = prepare_events(posted.size()); !s.ok()) return all_refused(s.error());
  Database::Transaction transaction(db_);
  std::vector<Result<Inserted>> inserted;
  std::vector<Event> events;
  for (const Posted& one : posted) {
    inserted.push_back(insert_one(transaction, one, room - events.size(), events));
    if (!inserted.back().ok() && inserted.back().error().code == ErrorCode::kIo)
      return all_refused(inserted.back().error());
  }
  if (Status s = transaction.commit(); !s.ok()) return all_refused(s.error());
  for (Event& event : events) events_.publish(std::move(event));
  return inserted;
}

Result<SqliteJobStore::Inserted> SqliteJobStore::insert_one(Database::Transaction& transaction,
                                                            const Posted& posted, size_t room,
                                                            std::vector<Event>& events) {
  const std::optional<IdempotencyKey>& key = posted.key;
  if (key) {
    Result<std::optional<JobRecord>> known = find_key(*key);
    if (!known.ok()) return known.error();
    if (known.value()) return Inserted{*std::move(known).value(), false};
  }
  if (room == 0) return Error{ErrorCode::kBusy, "the queue of jobs is full; try again later", ""};
  JobRecord job;
  job.request = posted.request;
  job.created_ms = now_ms_();
  Query query(transaction.handle(),
              "INSERT INTO jobs(state, request, created_ms) VALUES('queued',?,?) RETURNING id");
  query.bind(proto::job_request_to_json(job.request)).bind(job.created_ms);
  if (query.next()) job.id.value = static_cast<uint64_t>(query.integer(0));
  if (Status s = query.run(); !s.ok()) return s.error();
  if (Status s = write_log(transaction, job.id, "info", "queued"); !s.ok()) return s.error();
  if (key) {
    Status forgotten =
        Query(transaction.handle(), "DELETE FROM idempotency_keys WHERE created_ms<=? OR key=?")
            .bind(job.created_ms - kKeyMs)
            .bind(key->key)
            .run();
    if (!forgotten.ok()) return forgotten.error();
    Status kept = Query(transaction.handle(), "INSERT INTO idempotency_keys VALUES(?,?,?,?)")
                      .bind(key->key)
                      .bind(key->request)
                      .bind(job.id.value)
                      .bind(job.created_ms)
                      .run();
    if (!kept.ok()) return kept.error();
  }
  Event event{0, job.id.text(), "state", proto::state_event(job.id.text(), "queued", {})};
  if (Status s = write_event(transaction, event); !s.ok()) return s.error();
  events.push_back(std::move(event));
  return Inserted{std::move(job), true};
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
  return Error{ErrorCode::kNotFound, "no job " + id.text(), ""};
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
  if (!has_ended(job.value().state))
    return Error{ErrorCode::kConflict,
                 "the job has not ended: it is " + std::string(to_string(job.value().state)), ""};
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
  if (user.next())
    return Error{ErrorCode::kConflict,
                 "job " + JobId{static_cast<uint64_t>(user.integer(0))}.text() +
                     ", which has not ended, renders it",
                 ""};
  if (Status s = user.status(); !s.ok()) return s;
  return remove();
}

Result<JobRecord> SqliteJobStore::move(JobId id, JobState to, const Change& change) {
  Database::Session session(db_);
  if (Status s = prepare_events(); !s.ok()) return s.error();
  Database::Transaction transaction(db_);
  Result<JobRecord> found = read(transaction.handle(), id);
  if (!found.ok()) return found.error();
  JobRecord job = std::move(found).value();
  if (job.damaged || !can_move(job.state, to)) {
    return Error{ErrorCode::kConflict,
                 "the job is " + std::string(to_string(job.state)) + " and cannot become " +
                     std::string(to_string(to)),
                 ""};
  }
  if (change.claim && *change.claim != job.claim)
    return Error{ErrorCode::kConflict, "another run has the job now", ""};
  job.state = to;
  if (change.edit) change.edit(job);
  if (has_ended(to)) job.ended_ms = now_ms_();
  if (to == JobState::kPreparing) {
    job.started_ms = now_ms_();
    ++job.attempts;
    ++job.claim;
  }
  if (to == JobState::kQueued) {
    job.started_ms.reset();
    job.ended_ms.reset();
  }

  std::vector<Event> events = change.events;
  const std::string name = id.text(), state(to_string(to));
  events.push_back({0, name, "state", proto::state_event(name, state, job.error)});
  if (has_ended(to)) events.push_back({0, name, "done", proto::done_event(name, state)});
  if (Status s = write(transaction, job); !s.ok()) return s.error();
  const Status logged = write_log(transaction, id, job.error ? "error" : "info",
                                  state + (job.error ? ": " + job.error->text() : ""));
  if (!logged.ok()) return logged.error();
  for (Event& event : events) {
    if (Status s = write_event(transaction, event); !s.ok()) return s.error();
  }
  if (change.table)
    if (Status s = SqliteTableIndex::record(transaction, *change.table); !s.ok()) return s.error();
  if (Status s = transaction.commit(); !s.ok()) return s.error();
  for (Event& event : events) events_.publish(std::move(event));
  return job;
}

void SqliteJobStore::publish_hint(Event event) {
  {
    std::lock_guard lock(hints_mutex_);
    hints_.push_back(std::move(event));
    if (hints_.size() > kMostHints) hints_.erase(hints_.begin());
  }
  const Database::Session session(db_, std::try_to_lock);
  if (!session.held()) return;
  if (Status s = prepare_events(0); !s.ok()) spdlog::error("events: {}", s.error().text());
}

Status SqliteJobStore::restore_events() {
  Database::Session session(db_);
  {
    Query query(session.handle(), "SELECT value FROM counters WHERE name='event'");
    if (query.next()) reserved_up_to_ = static_cast<uint64_t>(query.integer(0));
    if (Status s = query.status(); !s.ok()) return s;
  }
  {
    // Of a damaged folder the counter may be behind; ids must rise all the same.
    Query query(session.handle(), "SELECT MAX(id) FROM events WHERE id > 0");
    if (query.next() && !query.is_null(0))
      reserved_up_to_ = std::max(reserved_up_to_, static_cast<uint64_t>(query.integer(0)));
    if (Status s = query.status(); !s.ok()) return s;
  }
  last_event_id_ = reserved_up_to_;
  Status pruned = Query(session.handle(),
                        "DELETE FROM events WHERE id <= (SELECT id FROM events ORDER BY id DESC "
                        "LIMIT 1 OFFSET ?)")
                      .bind(kEventsKept)
                      .run();
  if (!pruned.ok()) return pruned;
  std::vector<Event> events;
  Query query(session.handle(), "SELECT id, job, kind, data FROM events WHERE id > 0 ORDER BY id");
  while (query.next()) {
    events.push_back(
        {static_cast<uint64_t>(query.integer(0)), query.text(1), query.text(2), query.text(3)});
  }
  if (Status s = query.status(); !s.ok()) return s;
  const uint64_t lost = events.empty() ? reserved_up_to_ : events.front().id - 1;
  events_.restore(lost, std::move(events), reserved_up_to_);
  return {};
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
