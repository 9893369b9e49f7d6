// A job's states, the legal moves between them, and its record. Plain data.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "proto/messages.h"

namespace qray::server {

enum class JobState {
  kQueued,
  kPreparing,
  kLearning,
  kRendering,
  kFinalizing,
  kSucceeded,
  kPausing,
  kPaused,
  kCanceling,
  kCanceled,
  kFailed,
};

constexpr std::string_view kJobStateNames[] = {"queued",     "preparing", "learning", "rendering",
                                               "finalizing", "succeeded", "pausing",  "paused",
                                               "canceling",  "canceled",  "failed"};

constexpr std::string_view to_string(JobState state) {
  return kJobStateNames[static_cast<size_t>(state)];
}
std::optional<JobState> parse_job_state(std::string_view name);

constexpr bool has_ended(JobState state) {
  return state == JobState::kSucceeded || state == JobState::kCanceled ||
         state == JobState::kFailed;
}
constexpr bool is_running(JobState state) {
  return !has_ended(state) && state != JobState::kQueued && state != JobState::kPaused;
}

// The only legal moves; each writes the record and its event in one transaction (JobStore::move).
constexpr bool can_move(JobState from, JobState to) {
  using enum JobState;
  switch (from) {
    case kQueued:
      return to == kPreparing || to == kPaused || to == kCanceled || to == kFailed;
    case kPreparing:
      return to == kLearning || to == kRendering || to == kPausing || to == kCanceling ||
             to == kFailed || to == kQueued;  // queued: the server stops or stopped
    case kLearning:
      return to == kRendering || to == kPausing || to == kCanceling || to == kFailed ||
             to == kQueued;
    case kRendering:
      return to == kFinalizing || to == kPausing || to == kCanceling || to == kFailed ||
             to == kQueued;
    case kFinalizing:
      return to == kSucceeded || to == kCanceling || to == kFailed || to == kQueued;
    case kPausing:
      return to == kPaused || to == kCanceling || to == kFailed;
    case kPaused:
      return to == kQueued || to == kCanceled;
    case kCanceling:
      return to == kCanceled;
    case kSucceeded:
      return to == kQueued;  // more is asked of it
    case kCanceled:
    case kFailed:
      return false;
  }
  return false;
}

// A job's number; "j000001" on the wire.
struct JobId {
  uint64_t value = 0;
  auto operator<=>(const JobId&) const = default;
  std::string text() const;
  static std::optional<JobId> parse(std::string_view text);
};

constexpr int kMaxAttempts = 3;  // runs that the server did not survive, without a checkpoint

struct JobRecord {
  JobId id;
  JobState state = JobState::kQueued;
  JobRequest request;
  int64_t created_ms = 0;  // since 1970-01-01 UTC
  std::optional<int64_t> started_ms, ended_ms;
  proto::JobProgress progress;
  std::optional<proto::JobError> error;
  std::string table_in, table_out;  // ids; empty: none
  std::string stats_json;
  bool biased = false;
  std::vector<std::string> warnings;
  int attempts = 0;
  // How often it was claimed. A run names its own with each move, so that one that was given up for
  // dead and comes back changes nothing.
  uint64_t claim = 0;
  bool damaged = false;  // its row cannot be read: failed, with what could be read

  proto::JobInfo info() const;
};

}  // namespace qray::server
