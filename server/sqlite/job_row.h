// A row of the table of jobs as its record. Pure functions.
#pragma once

#include "server/model/job.h"
#include "server/sqlite/database.h"

namespace qray::server {

// What read_job() reads, in its order.
inline constexpr const char* kJobColumns =
    "id, state, request, created_ms, started_ms, ended_ms, fraction, samples, seconds, "
    "error_message, error_where, table_in, table_out, stats, biased, warnings, attempts, claim";

// Of a row that cannot be read: what could be read, and JobRecord::damaged.
JobRecord read_job(const Query& row);

}  // namespace qray::server
