// How many jobs are in which state, and how long the oldest queued one waits: for /metrics. Any
// thread.
#pragma once

#include <map>

#include "server/store/database.h"

namespace qray::server {

struct JobCounts {
  std::map<std::string, int64_t> by_state;
  std::optional<int64_t> oldest_queued_ms;  // when it was made
};
Result<JobCounts> count_jobs(Database& db);

}  // namespace qray::server
