// Jobs, their events and their logs on disk. Every change of a job and the events it causes are one
// transaction, durable when the call returns; only then are the events published. Any thread.
// What a store must do is what tests/server/store/store_conformance_test.cpp asks of each.
#pragma once

#include <functional>
#include <map>
#include <span>

#include "core/base/result.h"
#include "server/model/job.h"
#include "server/store/event_log.h"
#include "server/store/table_index.h"

namespace qray::server {

class JobStore {
 public:
  virtual ~JobStore() = default;

  // After a start: recent events go back to the log; jobs that were canceling are canceled; those
  // that were pausing are paused; running ones are queued again, or failed after kMaxAttempts.
  // Returns the queued jobs, oldest first. Where others run jobs too, theirs are left to them.
  virtual Result<std::vector<JobRecord>> recover();

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
  virtual std::vector<Result<Inserted>> insert(std::span<const Posted> posted, size_t room) = 0;
  virtual Result<JobRecord> get(JobId id) const = 0;    // kNotFound
  Result<JobRecord> find(const std::string& id) const;  // as a client names it
  // Does `remove` unless a job that has not ended renders this scene (kConflict). No job is
  // inserted meanwhile.
  virtual Status remove_scene(const std::string& scene,
                              const std::function<Status()>& remove) const = 0;
  // Of a time, milliseconds: at `from` or after it, and before `before`.
  struct Times {
    std::optional<int64_t> from{}, before{};
  };
  // That a job's id, scene, method or one of its labels ("name:value") contains, in small letters.
  struct Word {
    std::string text;
    std::string scenes{};  // ",one,two,": their jobs have the word too, in their scene's title
  };
  struct Filter {
    std::optional<JobId> before{};                              // ids below this one
    std::vector<JobState> states{};                             // one of these; none: any
    std::vector<std::pair<std::string, std::string>> labels{};  // name, value; all of these
    std::optional<std::string> table{};                         // that they used or made
    Times created{}, ended{};
    std::vector<Word> words{};  // all of these
  };
  // Newest first. A job whose row cannot be read is listed too (JobRecord::damaged).
  virtual Result<std::vector<JobRecord>> list(size_t limit, const Filter& filter) const = 0;
  virtual Result<std::vector<JobId>> open() const = 0;  // have not ended; the oldest first
  virtual Result<std::vector<JobId>> ended_before(int64_t ms, size_t limit) const = 0;
  struct Ids {
    std::vector<JobId> there;  // rising
    JobId newest;              // that was ever given
  };
  virtual Result<Ids> ids() const = 0;
  virtual Status give_no_id_up_to(JobId id) = 0;
  struct Counts {
    std::map<JobState, uint64_t> by_state;    // those that have any
    std::optional<int64_t> oldest_queued_ms;  // when it was made
  };
  virtual Result<Counts> count() const = 0;

  // Forgets an ended job, its log, events and key (kConflict: it has not ended).
  virtual Status remove(JobId id) = 0;

  // A line in the job's own log, of the last kLogLines; a text of one line. Best effort.
  virtual void log(JobId id, std::string_view level, std::string_view text) = 0;
  struct LogLine {
    int64_t time_ms = 0;
    std::string level, text;
  };
  virtual Result<std::vector<LogLine>> log_of(JobId id) const = 0;
  static constexpr int kLogLines = 1000;
  // Writes something, durably, to find out whether that goes.
  virtual Status try_writing() = 0;
  virtual bool is_new() const = 0;  // it was made at this start

  // The running job has got somewhere: starts before count no more against kMaxAttempts.
  virtual Status reset_attempts(JobId id) = 0;

  struct Change {
    std::function<void(JobRecord&)> edit;  // of the record, before it is written; may be empty
    std::vector<Event> events;             // before the state's own
    std::optional<TableRow> table;         // that it made: recorded with the move
    // Of the run that asks: kConflict where the job has been claimed anew since.
    std::optional<uint64_t> claim;
  };
  // Changes what was asked for, in any state. kConflict: the record is damaged.
  virtual Result<JobRecord> update(JobId id, const std::function<void(JobRequest&)>& edit) = 0;
  // The one transition function: kConflict when can_move() says no.
  virtual Result<JobRecord> move(JobId id, JobState to, const Change& change = {}) = 0;

  // An event that is not worth a write: lost by a restart, though its id is never used again. Waits
  // for no writer: where one is at work, the event is published with what comes next.
  virtual void publish_hint(Event event) = 0;

 protected:
  // At a start: what is kept of the events goes back to the log.
  virtual Status restore_events() = 0;
  // Of a job whose run has died, or that waits: what recover() says. It, if it is queued then.
  Result<std::optional<JobRecord>> take_up(JobId id);
  // Of a job whose record cannot be read; what can be read of it stays as it is.
  virtual Status fail_damaged(const JobRecord& job) = 0;
};

}  // namespace qray::server
