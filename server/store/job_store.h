// Jobs and their events on disk. Every change of a job and the events it causes are one
// transaction, durable when the call returns; only then are the events published. Any thread.
#pragma once

#include <functional>

#include "server/jobs/event_log.h"
#include "server/jobs/job.h"
#include "server/store/database.h"

namespace qray::server {

class JobStore {
 public:
  // Publishes to `events`; both must outlive the store. `now_ms`: the time of day.
  JobStore(Database& db, EventLog& events, std::function<int64_t()> now_ms)
      : db_(db), events_(events), now_ms_(std::move(now_ms)) {}

  // After a start: recent events go back to the log; jobs that were canceling are canceled; running
  // ones are queued again, or failed after kMaxAttempts. Returns the queued jobs, oldest first.
  Result<std::vector<JobId>> recover();

  Result<JobRecord> insert(const proto::JobRequest& request);
  Result<JobRecord> get(JobId id) const;  // kNotFound
  // Does `remove` unless a job that has not ended renders this scene (kConflict). No job is
  // inserted meanwhile.
  Status remove_scene(const std::string& scene, const std::function<Status()>& remove) const;
  // Newest first, ids below `before` (none: from the newest).
  Result<std::vector<JobRecord>> list(size_t limit, std::optional<JobId> before) const;

  struct Change {
    std::function<void(JobRecord&)> edit;  // of the record, before it is written; may be empty
    std::vector<Event> events;             // before the state's own
    std::function<Status(Database::Session&)> also;  // more writes in the transaction
  };
  // The one transition function: kConflict when can_move() says no.
  Result<JobRecord> move(JobId id, JobState to, const Change& change = {});

  // An event that is not worth a write: lost by a restart, though its id is never used again.
  Status publish_hint(Event event);

 private:
  Status reserve_event_ids();  // before a transaction begins: it must not be rolled back
  Status write(Database::Session& session, const JobRecord& record);
  Status write_event(Database::Session& session, Event& event);
  Status load_events();

  Database& db_;
  EventLog& events_;
  std::function<int64_t()> now_ms_;
  uint64_t last_event_id_ = 0;   // guarded by the database's session
  uint64_t reserved_up_to_ = 0;  // ids on disk as used
};

}  // namespace qray::server
