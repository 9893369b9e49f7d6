// The store of jobs in a Database (job_store.h). Any thread.
#pragma once

#include <mutex>

#include "server/sqlite/database.h"
#include "server/store/job_store.h"

namespace qray::server {

class SqliteJobStore final : public JobStore {
 public:
  // Publishes to `events`; both must outlive the store. `now_ms`: the time of day.
  SqliteJobStore(Database& db, EventLog& events, std::function<int64_t()> now_ms)
      : db_(db), events_(events), now_ms_(std::move(now_ms)) {}

  std::vector<Result<Inserted>> insert(std::span<const Posted> posted, size_t room) override;
  Result<JobRecord> get(JobId id) const override;
  Status remove_scene(const std::string& scene,
                      const std::function<Status()>& remove) const override;
  Result<std::vector<JobRecord>> list(size_t limit, const Filter& filter) const override;
  Result<std::vector<JobId>> open() const override;
  Result<std::vector<JobId>> ended_before(int64_t ms, size_t limit) const override;
  Result<Ids> ids() const override;
  Status give_no_id_up_to(JobId id) override;
  Result<Counts> count() const override;
  Status remove(JobId id) override;
  void log(JobId id, std::string_view level, std::string_view text) override;
  Result<std::vector<LogLine>> log_of(JobId id) const override;
  Status try_writing() override;
  bool is_new() const override { return db_.is_new(); }
  Status reset_attempts(JobId id) override;
  Result<JobRecord> update(JobId id, const std::function<void(JobRequest&)>& edit) override;
  Result<JobRecord> move(JobId id, JobState to, const Change& change = {}) override;
  void publish_hint(Event event) override;

 private:
  // In a Session, before a transaction begins, whose end must not undo it: reserves ids for so many
  // events, and publishes the hints that wait.
  Status prepare_events(uint64_t at_least = 16);
  Result<JobRecord> read(sqlite3* db, JobId id) const;
  // The job of this key; none: not used yet.
  Result<std::optional<JobRecord>> find_key(const IdempotencyKey& key) const;
  Result<Inserted> insert_one(Database::Transaction& transaction, const Posted& posted, size_t room,
                              std::vector<Event>& events);
  Status write(Database::Session& session, const JobRecord& record);
  Status write_event(Database::Session& session, Event& event);
  Status write_log(Database::Session& session, JobId id, std::string_view level,
                   std::string_view text);
  Status reserve_event_ids(uint64_t at_least);
  Status restore_events() override;
  Status fail_damaged(const JobRecord& job) override;

  Database& db_;
  EventLog& events_;
  std::function<int64_t()> now_ms_;
  std::mutex hints_mutex_;
  std::vector<Event> hints_;     // that wait
  uint64_t last_event_id_ = 0;   // guarded by the database's session
  uint64_t reserved_up_to_ = 0;  // ids on disk as used
};

}  // namespace qray::server
