// Jobs, their events and logs in PostgreSQL (job_store.h), and who runs them (shared_jobs.h). A
// transaction locks the job's row first, and of others none: so none waits for another in a circle.
// Any thread.
#pragma once

#include <condition_variable>
#include <mutex>
#include <thread>

#include "server/postgres/pg_database.h"
#include "server/postgres/pg_records.h"
#include "server/store/job_move.h"
#include "server/store/shared_jobs.h"

namespace qray::server {

class PgJobStore final : public JobStore, public SharedJobs {
 public:
  // Publishes to `events`, which must outlive the store. `now_ms`: the time of day.
  PgJobStore(PgDatabase& db, EventLog& events, std::function<int64_t()> now_ms, PgOptions options);
  ~PgJobStore() override;
  const std::string& worker() const { return worker_; }  // this process's name

  Result<std::vector<JobRecord>> recover() override;
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

  Result<std::optional<JobRecord>> claim(bool suspects_too) override;
  Result<size_t> queued() const override;
  Result<std::vector<Held>> renew(std::span<const Run> runs) override;
  std::chrono::milliseconds lease() const override { return options_.lease; }
  Result<std::vector<JobId>> take_up_lost() override;
  void wait_for_news(std::stop_token stop, std::chrono::milliseconds time) override;
  Result<bool> present(const WorkerInfo& me) override;
  Status leave() override;
  Result<std::vector<WorkerInfo>> workers() const override;
  Status drain(const std::string& worker) override;

 private:
  using Transaction = PgDatabase::Transaction;
  static Result<JobRecord> read_locked(Transaction& transaction, JobId id);
  Result<Inserted> insert_one(Transaction& transaction, const Posted& posted, size_t room);
  Status lock_keys(Transaction& transaction, std::span<const Posted> posted) const;
  Status write(Transaction& transaction, const JobRecord& job);
  static Status write_event(Transaction& transaction, const Event& event, bool hint = false);
  Status write_log(PgDatabase::Session& session, JobId id, std::string_view level,
                   std::string_view text);
  Status take_up_all_lost();
  // Of a run: it begins, or the job is nobody's any more.
  Status write_run(Transaction& transaction, const JobRecord& job);
  double lease_seconds() const { return std::chrono::duration<double>(options_.lease).count(); }
  // So that others look at once.
  void tell_others();

  Status restore_events() override;
  Status restore_log();
  Status fail_damaged(const JobRecord& job) override;
  // Gives ids to new events. Under the lock of it.
  Status number_events(Transaction& transaction);
  Status write_hints();
  // Publishes what is new, whoever wrote it.
  void publish_new();
  Status read_new();
  void follow(std::stop_token stop);

  PgDatabase& db_;
  EventLog& events_;
  const std::function<int64_t()> now_ms_;
  const PgOptions options_;
  const std::string host_, worker_;
  std::mutex lost_mutex_;
  std::vector<JobId> lost_;  // that were taken up, until take_up_lost() says so
  std::mutex hints_mutex_;
  std::vector<Event> hints_;  // that wait to be written
  std::mutex publish_mutex_;
  uint64_t published_ = 0;       // the newest id
  bool publish_failed_ = false;  // and that was said
  std::mutex news_mutex_;
  std::condition_variable_any news_came_;
  uint64_t news_ = 0;
  std::jthread follower_;  // last: it uses the others
};

}  // namespace qray::server
