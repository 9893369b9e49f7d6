// All records in one PostgreSQL database, which several processes share.
#pragma once

#include <functional>

#include "server/store/records.h"

namespace qray::server {

struct PgOptions {
  bool publishes = true;  // somebody in this process reads the events
  std::chrono::milliseconds lease{15'000};
};

// `url`: postgresql://... as libpq takes it. Jobs publish to `events`.
Result<std::unique_ptr<Records>> open_pg_records(const std::string& url, EventLog& events,
                                                 const std::function<int64_t()>& now_ms,
                                                 const PgOptions& options = {});

}  // namespace qray::server
