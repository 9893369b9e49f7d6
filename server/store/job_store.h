// Jobs, their events and their logs on disk. Every change of a job and the events it causes are one
// transaction, durable when the call returns; only then are the events published. Any thread.
#pragma once

#include <functional>
#include <map>
#include <span>

#include "server/model/job.h"
#include "server/store/database.h"
#include "server/store/event_log.h"

namespace qray::server {

class JobStore {
 public:
  // Publishes to `events`; both must outlive the store. `now_ms`: the time of day.
  JobStore(Database& db, EventLog& events, std::function<int64_t()> now_ms)
      : db_(db), events_(events), now_ms_(std::move(now_ms)) {}

  // After a start: recent events go back to the log; jobs that were canceling are canceled; those
  // that were pausing are paused; running ones are queued again, or failed after kMaxAttempts.
  // Returns the queued jobs, oldest first.
  Result<std::vector<JobRecord>> recover();

  // By what a client knows a request again: asked a second time within a day, the first job is the
  // answer. `request`: a hash of what was asked.
  struct IdempotencyKey {
    std::string key, request;
  };
  struct Posted {
    JobRequest request;
    std::optional<IdempotencyKey> key;
  };
  struct Inserted {
    JobRecord job;
    bool is_new = true;  // else it is the job of the key
  };
  // All in one transaction, in their order; those that are new up to `room`, the others are kBusy.
  // kConflict: the key was used for another request. What the disk refuses is refused for all.
  std::vector<Result<Inserted>> insert(std::span<const Posted> posted, size_t room);
  Result<JobRecord> get(JobId id) const;                // kNotFound
  Result<JobRecord> find(const std::string& id) const;  // as a client names it
  // Does `remove` unless a job that has not ended renders this scene (kConflict). No job is
  // inserted meanwhile.
  Status remove_scene(const std::string& scene, const std::function<Status()>& remove) const;
  struct Filter {
    std::optional<JobId> before{};                              // ids below this one
    std::vector<JobState> states{};                             // one of these; none: any
    std::vector<std::pair<std::string, std::string>> labels{};  // name, value; all of these
    std::optional<std::string> table{};                         // that they used or made
  };
  // Newest first. A job whose row cannot be read is listed too (JobRecord::damaged).
  Result<std::vector<JobRecord>> list(size_t limit, const Filter& filter) const;
  Result<std::vector<JobId>> open() const;  // have not ended; the oldest first
  Result<std::vector<JobId>> ended_before(int64_t ms, size_t limit) const;
  struct Ids {
    std::vector<JobId> there;  // rising
    JobId newest;              // that was ever given
  };
  Result<Ids> ids() const;
  Status give_no_id_up_to(JobId id);
  struct Counts {
    std::map<JobState, uint64_t> by_state;    // those that have any
    std::optional<int64_t> oldest_queued_ms;  // when it was made
  };
  Result<Counts> count() const;

  // Forgets an ended job, its log, events and key (kConflict: it has not ended).
  Status remove(JobId id);

  // A line in the job's own log, of the last kLogLines; a text of one line. Best effort.
  void log(JobId id, std::string_view level, std::string_view text);
  struct LogLine {
    int64_t time_ms = 0;
    std::string level, text;
  };
  Result<std::vector<LogLine>> log_of(JobId id) const;
  static constexpr int kLogLines = 1000;

  // The running job has got somewhere: starts before count no more against kMaxAttempts.
  Status reset_attempts(JobId id);

  struct Change {
    std::function<void(JobRecord&)> edit;  // of the record, before it is written; may be empty
    std::vector<Event> events;             // before the state's own
    std::function<Status(Database::Session&)> also;  // more writes in the transaction
  };
  // The one transition function: kConflict when can_move() says no.
  Result<JobRecord> move(JobId id, JobState to, const Change& change = {});

  // An event that is not worth a write: lost by a restart, though its id is never used again. Waits
  // for no writer: where one is at work, the event is published with what comes next.
  void publish_hint(Event event);

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
  Status load_events();
  Status reserve_event_ids(uint64_t at_least);
  Status fail_damaged(const JobRecord& job);

  Database& db_;
  EventLog& events_;
  std::function<int64_t()> now_ms_;
  std::mutex hints_mutex_;
  std::vector<Event> hints_;     // that wait
  uint64_t last_event_id_ = 0;   // guarded by the database's session
  uint64_t reserved_up_to_ = 0;  // ids on disk as used
};

}  // namespace qray::server
