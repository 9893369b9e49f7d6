// Which database the records are in, by what --store says.
#pragma once

#include "server/operation/config.h"
#include "server/store/records.h"

namespace qray::server {

// Empty: a SQLite file in the data folder, this process's alone. `publishes`: somebody in this
// process reads `events`.
Result<std::unique_ptr<Records>> open_records(const Config& config, EventLog& events,
                                              const std::function<int64_t()>& now_ms,
                                              bool publishes);

}  // namespace qray::server
