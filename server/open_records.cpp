#include "server/open_records.h"

#include "server/sqlite/sqlite_records.h"
#ifdef QRAY_POSTGRES
#include "server/postgres/pg_records.h"
#endif

namespace qray::server {

Result<std::unique_ptr<Records>> open_records(const Config& config, EventLog& events,
                                              const std::function<int64_t()>& now_ms,
                                              [[maybe_unused]] bool publishes) {
  if (config.store.empty()) return SqliteRecords::open(config.data / "qray.sqlite", events, now_ms);
#ifdef QRAY_POSTGRES
  PgOptions options;
  options.publishes = publishes;
  options.lease = std::chrono::milliseconds(static_cast<int64_t>(config.lease_seconds * 1000));
  return open_pg_records(config.store, events, now_ms, options);
#else
  return Error{ErrorCode::kUnsupported,
               "this qrayd was built without PostgreSQL: build it where libpq-dev is installed",
               "--store"};
#endif
}

}  // namespace qray::server
