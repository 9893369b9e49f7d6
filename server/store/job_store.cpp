#include "server/store/job_store.h"

#include <algorithm>
#include <climits>

#include "proto/events.h"
#include "server/store/lines.h"

namespace qray::server {
namespace {

constexpr uint64_t kIdBlock = 10'000;   // event ids reserved by one write
constexpr int64_t kEventsKept = 2'000;  // on disk, at a start

constexpr const char* kColumns =
    "id, state, request, created_ms, started_ms, ended_ms, fraction, samples, seconds, "
    "error_message, error_where, table_in, table_out, stats, biased, warnings, attempts";

// What was accepted once is read back whatever today's limits are.
Result<proto::JobRequest> stored_request(const std::string& json) {
  proto::RequestLimits limits;
  limits.max_seconds = 1e9;
  limits.max_pixels = INT64_MAX;
  limits.max_grid = INT_MAX;
  auto parsed = proto::parse_job_request(json, limits);
  if (const auto* problem = std::get_if<proto::Problem>(&parsed)) {
    return Error{ErrorCode::kCorrupt, "stored request: " + problem->detail, ""};
  }
  return std::get<proto::JobRequest>(std::move(parsed));
}

Result<JobRecord> read_row(const Query& row) {
  JobRecord job;
  job.id.value = static_cast<uint64_t>(row.integer(0));
  const std::optional<JobState> state = parse_job_state(row.text(1));
  if (!state) return Error{ErrorCode::kCorrupt, "unknown state " + row.text(1), job.id.text()};
  job.state = *state;
  Result<proto::JobRequest> request = stored_request(row.text(2));
  if (!request.ok()) return request.error();
  job.request = std::move(request).value();
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
  return job;
}

}  // namespace

Status JobStore::reserve_event_ids() {
  constexpr uint64_t kEnough = 16;  // for any one transaction
  Database::Session session(db_);
  if (last_event_id_ + kEnough <= reserved_up_to_) return {};
  Query query(session.handle(),
              "INSERT INTO counters VALUES('event', ?1) "
              "ON CONFLICT(name) DO UPDATE SET value = ?1");
  query.bind(reserved_up_to_ + kIdBlock);
  if (Status s = query.run(); !s.ok()) return s;
  reserved_up_to_ += kIdBlock;
  return {};
}

Status JobStore::write_event(Database::Session& session, Event& event) {
  event.id = ++last_event_id_;
  return Query(session.handle(), "INSERT INTO events VALUES(?,?,?,?)")
      .bind(event.id)
      .bind(event.job)
      .bind(event.kind)
      .bind(event.data)
      .run();
}

Status JobStore::write(Database::Session& session, const JobRecord& job) {
  std::optional<std::string> message, where;
  if (job.error) {
    message = job.error->message;
    where = job.error->where;
  }
  return Query(session.handle(),
               "UPDATE jobs SET state=?, request=?, started_ms=?, ended_ms=?, fraction=?, "
               "samples=?, seconds=?, error_message=?, error_where=?, table_in=?, table_out=?, "
               "stats=?, biased=?, warnings=?, attempts=? WHERE id=?")
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
      .bind(job.id.value)
      .run();
}

Result<JobRecord> JobStore::insert(const proto::JobRequest& request) {
  Database::Session session(db_);
  if (Status s = reserve_event_ids(); !s.ok()) return s.error();
  Database::Transaction transaction(db_);
  JobRecord job;
  job.request = request;
  job.created_ms = now_ms_();
  Query query(transaction.handle(),
              "INSERT INTO jobs(state, request, created_ms) VALUES('queued',?,?) RETURNING id");
  query.bind(proto::job_request_to_json(request)).bind(job.created_ms);
  if (query.next()) job.id.value = static_cast<uint64_t>(query.integer(0));
  if (Status s = query.run(); !s.ok()) return s.error();
  Event event{0, job.id.text(), "state", proto::state_event(job.id.text(), "queued", {})};
  if (Status s = write_event(transaction, event); !s.ok()) return s.error();
  if (Status s = transaction.commit(); !s.ok()) return s.error();
  events_.publish(std::move(event));
  return job;
}

Result<JobRecord> JobStore::get(JobId id) const {
  Database::Session session(db_);
  const std::string sql = std::string("SELECT ") + kColumns + " FROM jobs WHERE id=?";
  Query query(session.handle(), sql.c_str());
  query.bind(id.value);
  if (query.next()) return read_row(query);
  if (Status s = query.status(); !s.ok()) return s.error();
  return Error{ErrorCode::kNotFound, "no job " + id.text(), ""};
}

Result<std::vector<JobRecord>> JobStore::list(size_t limit, std::optional<JobId> before) const {
  Database::Session session(db_);
  const std::string sql =
      std::string("SELECT ") + kColumns + " FROM jobs WHERE id < ? ORDER BY id DESC LIMIT ?";
  Query query(session.handle(), sql.c_str());
  query.bind(before ? static_cast<int64_t>(before->value) : INT64_MAX);
  query.bind(static_cast<int64_t>(limit));
  std::vector<JobRecord> jobs;
  while (query.next()) {
    Result<JobRecord> job = read_row(query);
    if (!job.ok()) return job.error();
    jobs.push_back(std::move(job).value());
  }
  if (Status s = query.status(); !s.ok()) return s.error();
  return jobs;
}

Status JobStore::remove_scene(const std::string& scene,
                              const std::function<Status()>& remove) const {
  Database::Session session(db_);
  Query user(session.handle(),
             "SELECT id FROM jobs WHERE state NOT IN ('succeeded','canceled','failed') AND "
             "json_extract(request, '$.scene')=? LIMIT 1");
  user.bind(scene);
  if (user.next())
    return Error{ErrorCode::kConflict,
                 "job " + JobId{static_cast<uint64_t>(user.integer(0))}.text() +
                     ", which has not ended, renders it",
                 ""};
  if (Status s = user.status(); !s.ok()) return s;
  return remove();
}

Result<JobRecord> JobStore::move(JobId id, JobState to, const Change& change) {
  Database::Session session(db_);
  if (Status s = reserve_event_ids(); !s.ok()) return s.error();
  Database::Transaction transaction(db_);
  Result<JobRecord> found = get(id);
  if (!found.ok()) return found.error();
  JobRecord job = std::move(found).value();
  if (!can_move(job.state, to)) {
    return Error{ErrorCode::kConflict,
                 "the job is " + std::string(to_string(job.state)) + " and cannot become " +
                     std::string(to_string(to)),
                 ""};
  }
  job.state = to;
  if (change.edit) change.edit(job);
  if (has_ended(to)) job.ended_ms = now_ms_();
  if (to == JobState::kPreparing) {
    job.started_ms = now_ms_();
    ++job.attempts;
  }
  if (to == JobState::kQueued) job.started_ms.reset();

  std::vector<Event> events = change.events;
  const std::string name = id.text(), state(to_string(to));
  events.push_back({0, name, "state", proto::state_event(name, state, job.error)});
  if (has_ended(to)) events.push_back({0, name, "done", proto::done_event(name, state)});
  if (Status s = write(transaction, job); !s.ok()) return s.error();
  for (Event& event : events) {
    if (Status s = write_event(transaction, event); !s.ok()) return s.error();
  }
  if (change.also) {
    if (Status s = change.also(transaction); !s.ok()) return s.error();
  }
  if (Status s = transaction.commit(); !s.ok()) return s.error();
  for (Event& event : events) events_.publish(std::move(event));
  return job;
}

Status JobStore::publish_hint(Event event) {
  Database::Session session(db_);  // keeps ids in the order of publication
  if (Status s = reserve_event_ids(); !s.ok()) return s;
  event.id = ++last_event_id_;
  events_.publish(std::move(event));
  return {};
}

Status JobStore::load_events() {
  Database::Session session(db_);
  {
    Query query(session.handle(), "SELECT value FROM counters WHERE name='event'");
    if (query.next()) reserved_up_to_ = static_cast<uint64_t>(query.integer(0));
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
  Query query(session.handle(), "SELECT id, job, kind, data FROM events ORDER BY id");
  while (query.next()) {
    events.push_back(
        {static_cast<uint64_t>(query.integer(0)), query.text(1), query.text(2), query.text(3)});
  }
  if (Status s = query.status(); !s.ok()) return s;
  const uint64_t lost = events.empty() ? reserved_up_to_ : events.front().id - 1;
  events_.restore(lost, std::move(events), reserved_up_to_);
  return {};
}

Result<std::vector<JobId>> JobStore::recover() {
  if (Status s = load_events(); !s.ok()) return s.error();
  std::vector<std::pair<JobId, JobState>> open;
  {
    Database::Session session(db_);
    Query query(session.handle(),
                "SELECT id, state FROM jobs WHERE state NOT IN ('succeeded','canceled','failed') "
                "ORDER BY id");
    while (query.next()) {
      const std::optional<JobState> state = parse_job_state(query.text(1));
      if (state) open.emplace_back(JobId{static_cast<uint64_t>(query.integer(0))}, *state);
    }
    if (Status s = query.status(); !s.ok()) return s.error();
  }
  std::vector<JobId> queued;
  for (const auto& [id, state] : open) {
    if (state == JobState::kQueued) {
      queued.push_back(id);
      continue;
    }
    if (state == JobState::kCanceling) {
      Result<JobRecord> moved = move(id, JobState::kCanceled);
      if (!moved.ok()) return moved.error();
      continue;
    }
    Result<JobRecord> job = get(id);
    if (!job.ok()) return job.error();
    const bool give_up = job.value().attempts >= kMaxAttempts;
    Change change;
    change.edit = [&](JobRecord& record) {
      record.progress = {};
      if (give_up) {
        record.error = proto::JobError{
            "the server ended " + std::to_string(kMaxAttempts) + " times while it ran this job",
            ""};
      }
    };
    Result<JobRecord> moved = move(id, give_up ? JobState::kFailed : JobState::kQueued, change);
    if (!moved.ok()) return moved.error();
    if (!give_up) queued.push_back(id);
  }
  return queued;
}

}  // namespace qray::server
