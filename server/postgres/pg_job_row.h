// A row of the table of jobs as its record, and back. Pure functions.
#pragma once

#include "server/model/job.h"
#include "server/postgres/pg_connection.h"

namespace qray::server {

// What read_pg_job() reads, in its order, of `jobs` with its row of `runs` if it has one: a running
// job's progress is there.
inline constexpr const char* kPgJobColumns =
    "jobs.id, state, request, created_ms, started_ms, ended_ms, "
    "coalesce(runs.fraction, jobs.fraction), coalesce(runs.samples, jobs.samples), "
    "coalesce(runs.seconds, jobs.seconds), error_message, error_where, table_in, table_out, stats, "
    "biased, warnings, attempts, jobs.claim";
inline constexpr const char* kPgJobTables = "jobs LEFT JOIN runs ON runs.job=jobs.id";

// Of a row that cannot be read: what could be read, and JobRecord::damaged.
JobRecord read_pg_job(const PgRows& rows, int row);
std::vector<JobId> pg_ids(const PgRows& rows);  // of the first column

// The lowest is next. Each minute of waiting counts as a step of priority, so that none waits for
// ever.
int64_t pg_rank(const JobRecord& job);

}  // namespace qray::server
