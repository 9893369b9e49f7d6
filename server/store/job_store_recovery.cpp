// What JobStore does at a start: events that are kept, and jobs that a server which ended left.
#include <spdlog/spdlog.h>

#include <algorithm>

#include "server/store/job_store.h"

namespace qray::server {
namespace {

constexpr int64_t kEventsKept = 2'000;  // on disk, at a start

}  // namespace

Status JobStore::load_events() {
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

Result<std::vector<JobId>> JobStore::open() const {
  const Database::Reading reading(db_);
  Query query(reading.handle(),
              "SELECT id FROM jobs WHERE state NOT IN ('succeeded','canceled','failed') "
              "ORDER BY id");
  std::vector<JobId> ids;
  while (query.next()) ids.push_back({static_cast<uint64_t>(query.integer(0))});
  if (Status s = query.status(); !s.ok()) return s.error();
  return ids;
}

// What can be read of it stays as it is.
Status JobStore::fail_damaged(const JobRecord& job) {
  spdlog::error("job={} fails: {}", job.id.text(), job.error->text());
  Database::Session session(db_);
  return Query(session.handle(),
               "UPDATE jobs SET state='failed', ended_ms=?, error_message=?, error_where='' WHERE "
               "id=?")
      .bind(now_ms_())
      .bind(job.error->message)
      .bind(job.id.value)
      .run();
}

Result<std::vector<JobRecord>> JobStore::recover() {
  if (Status s = load_events(); !s.ok()) return s.error();
  const Result<std::vector<JobId>> open = this->open();
  if (!open.ok()) return open.error();
  std::vector<JobRecord> queued;
  for (const JobId id : open.value()) {
    Result<JobRecord> job = get(id);
    if (!job.ok()) return job.error();
    if (job.value().damaged) {
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
