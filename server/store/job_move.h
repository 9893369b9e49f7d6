// What a move changes, of the record and beside it: the same for any store. Pure functions.
#pragma once

#include <vector>

#include "server/store/job_store.h"

namespace qray::server {

struct JobMove {
  JobRecord job;              // as it is after the move
  std::vector<Event> events;  // in their order
  std::string log_level, log_text;
};

// kConflict: can_move() says no, or it is not the last claim's run that asks.
Result<JobMove> job_move(JobRecord job, JobState to, const JobStore::Change& change,
                         int64_t now_ms);
// That it is in its state.
Event state_event_of(const JobRecord& job);

inline constexpr int64_t kIdempotencyKeyMs = 24 * 3600 * 1000;  // that a key is known

Error not_ended(JobState state);    // kConflict
Error key_of_another(JobId id);     // kConflict
Error no_job(JobId id);             // kNotFound
Error queue_is_full();              // kBusy
Error table_is_named(JobId by);     // kConflict
Error scene_is_rendered(JobId by);  // kConflict

}  // namespace qray::server
