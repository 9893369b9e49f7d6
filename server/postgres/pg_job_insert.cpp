// New jobs, and the keys by which a client asks for one a second time.
#include <set>

#include "server/postgres/pg_job_row.h"
#include "server/postgres/pg_job_store.h"

namespace qray::server {

// In one order, so that of two fronts that were given the same keys none waits for the other.
Status PgJobStore::lock_keys(Transaction& transaction, std::span<const Posted> posted) const {
  std::set<std::string> keys;
  for (const Posted& one : posted)
    if (one.key) keys.insert(one.key->key);
  for (const std::string& key : keys)
    if (Status s = transaction.change(
            "SELECT pg_advisory_xact_lock(hashtext('qray key'), hashtext($1))", {key});
        !s.ok())
      return s;
  return {};
}

std::vector<Result<PgJobStore::Inserted>> PgJobStore::insert(std::span<const Posted> posted,
                                                             size_t room) {
  const auto all_refused = [&](const Error& error) {
    return std::vector<Result<Inserted>>(posted.size(), error);
  };
  std::vector<Result<Inserted>> inserted;
  size_t are_new = 0;
  {
    Transaction transaction(db_);
    if (Status s =
            transaction.change("SELECT pg_advisory_xact_lock_shared(hashtext('qray scenes'))");
        !s.ok())
      return all_refused(s.error());
    if (Status s = lock_keys(transaction, posted); !s.ok()) return all_refused(s.error());
    for (const Posted& one : posted) {
      inserted.push_back(insert_one(transaction, one, room - are_new));
      if (!inserted.back().ok() && inserted.back().error().code == ErrorCode::kIo)
        return all_refused(inserted.back().error());
      if (inserted.back().ok() && inserted.back().value().is_new) ++are_new;
    }
    if (Status s = transaction.commit(); !s.ok()) return all_refused(s.error());
  }
  if (are_new > 0) tell_others();
  publish_new();
  return inserted;
}

Result<PgJobStore::Inserted> PgJobStore::insert_one(Transaction& transaction, const Posted& posted,
                                                    size_t room) {
  const std::optional<IdempotencyKey>& key = posted.key;
  const int64_t now = now_ms_();
  if (key) {
    const Result<PgRows> known =
        transaction.run("SELECT job, request FROM idempotency_keys WHERE key=$1 AND created_ms>$2",
                        {key->key, now - kIdempotencyKeyMs});
    if (!known.ok()) return known.error();
    if (!known.value().empty()) {
      const JobId id{known.value().number(0, 0)};
      if (known.value().text(0, 1) != key->request) return key_of_another(id);
      Result<JobRecord> job = read_locked(transaction, id);
      if (!job.ok()) return job.error();
      return Inserted{std::move(job).value(), false};
    }
  }
  if (room == 0) return queue_is_full();
  JobRecord job;
  job.request = posted.request;
  job.created_ms = now;
  const Result<PgRows> id = transaction.run(
      "INSERT INTO jobs(id, state, request, created_ms) "
      "VALUES(nextval('job_ids'), 'queued', '{}', $1) RETURNING id",
      {job.created_ms});
  if (!id.ok()) return id.error();
  job.id.value = id.value().number(0, 0);
  if (Status s = write(transaction, job); !s.ok()) return s.error();
  if (Status s = write_log(transaction, job.id, "info", "queued"); !s.ok()) return s.error();
  if (key) {
    if (Status s = transaction.change("DELETE FROM idempotency_keys WHERE key=$1", {key->key});
        !s.ok())
      return s.error();
    if (Status s = transaction.change("INSERT INTO idempotency_keys VALUES($1,$2,$3,$4)",
                                      {key->key, key->request, job.id.value, job.created_ms});
        !s.ok())
      return s.error();
  }
  if (Status s = write_event(transaction, state_event_of(job)); !s.ok()) return s.error();
  return Inserted{std::move(job), true};
}

}  // namespace qray::server
