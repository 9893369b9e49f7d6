// New jobs, and the keys by which a client asks for one a second time.
#include "server/sqlite/sqlite_job_store.h"
#include "server/store/job_move.h"

namespace qray::server {

Result<std::optional<JobRecord>> SqliteJobStore::find_key(const IdempotencyKey& key) const {
  Database::Session session(db_);
  Query query(session.handle(),
              "SELECT job, request FROM idempotency_keys WHERE key=? AND created_ms>?");
  query.bind(key.key).bind(now_ms_() - kIdempotencyKeyMs);
  if (!query.next()) {
    if (Status s = query.status(); !s.ok()) return s.error();
    return std::optional<JobRecord>();
  }
  const JobId id{static_cast<uint64_t>(query.integer(0))};
  if (query.text(1) != key.request) return key_of_another(id);
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
  if (room == 0) return queue_is_full();
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
            .bind(job.created_ms - kIdempotencyKeyMs)
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
  Event event = state_event_of(job);
  if (Status s = write_event(transaction, event); !s.ok()) return s.error();
  events.push_back(std::move(event));
  return Inserted{std::move(job), true};
}

}  // namespace qray::server
