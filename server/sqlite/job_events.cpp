// Events of jobs: their ids, which rise over any end of the server, and those that are only hints.
#include <spdlog/spdlog.h>

#include <algorithm>

#include "server/sqlite/sqlite_job_store.h"

namespace qray::server {
namespace {

constexpr uint64_t kIdBlock = 10'000;   // event ids reserved by one write
constexpr int64_t kEventsKept = 2'000;  // on disk, at a start
constexpr size_t kMostHints = 1000;     // that wait for a writer

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

}  // namespace qray::server
