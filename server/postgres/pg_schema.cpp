// The tables, and how those of an older qray become this one's.
#include <iterator>

#include "server/postgres/pg_database.h"

namespace qray::server {
namespace {

// What makes version n + 1 of version n. Times end in _ms where a process's clock wrote them; what
// several machines compare (leases) is of the database's own clock, and timestamptz.
constexpr const char* kSteps[] = {R"sql(
CREATE SEQUENCE job_ids;
CREATE TABLE jobs (
  id bigint PRIMARY KEY,
  state text NOT NULL,
  request text NOT NULL,                   -- JSON
  scene text NOT NULL DEFAULT '', wanted_table text NOT NULL DEFAULT '',  -- of the request
  labels jsonb NOT NULL DEFAULT '{}',      -- of the request
  rank bigint NOT NULL DEFAULT 0,          -- the lowest of the queued ones is next
  created_ms bigint NOT NULL, started_ms bigint, ended_ms bigint,
  fraction double precision NOT NULL DEFAULT 0, samples bigint NOT NULL DEFAULT 0,
  seconds double precision NOT NULL DEFAULT 0,
  error_message text, error_where text,
  table_in text NOT NULL DEFAULT '', table_out text NOT NULL DEFAULT '',
  stats text NOT NULL DEFAULT '',          -- JSON
  biased boolean NOT NULL DEFAULT false,
  warnings text NOT NULL DEFAULT '',       -- a line each
  attempts integer NOT NULL DEFAULT 0,
  claim bigint NOT NULL DEFAULT 0) WITH (fillfactor=70);
CREATE INDEX jobs_queued ON jobs(rank, id) WHERE state='queued';
CREATE INDEX jobs_open ON jobs(id) WHERE state NOT IN ('succeeded','canceled','failed');
CREATE INDEX jobs_by_state ON jobs(state, id);
CREATE INDEX jobs_by_end ON jobs(ended_ms) WHERE ended_ms IS NOT NULL;
CREATE INDEX jobs_by_table_in ON jobs(table_in, id) WHERE table_in <> '';
CREATE INDEX jobs_by_table_out ON jobs(table_out, id) WHERE table_out <> '';
CREATE INDEX jobs_by_label ON jobs USING gin(labels jsonb_path_ops);

-- Of a job that is claimed: who has it, and until when it is believed. Rows change often and stay
-- where they are (HOT), as no index has what changes.
CREATE TABLE runs (
  job bigint PRIMARY KEY, claim bigint NOT NULL, worker text NOT NULL,
  until timestamptz NOT NULL,
  fraction double precision NOT NULL DEFAULT 0, samples bigint NOT NULL DEFAULT 0,
  seconds double precision NOT NULL DEFAULT 0) WITH (fillfactor=40);

CREATE TABLE job_log (
  id bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  job bigint NOT NULL,
  time_ms bigint NOT NULL, level text NOT NULL, text text NOT NULL);
CREATE INDEX job_log_by_job ON job_log(job, id);
CREATE TABLE idempotency_keys (
  key text PRIMARY KEY,
  request text NOT NULL,                   -- SHA-256 of what was asked
  job bigint NOT NULL,
  created_ms bigint NOT NULL);
CREATE INDEX idempotency_keys_by_time ON idempotency_keys(created_ms);
CREATE INDEX idempotency_keys_by_job ON idempotency_keys(job);

-- Events are written here with what they tell of, and get their ids when they are moved to
-- `events`, by one process at a time: so ids are seen in their order.
CREATE TABLE new_events (
  place bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  job text NOT NULL, kind text NOT NULL, data text NOT NULL, hint boolean NOT NULL);
CREATE SEQUENCE event_ids;
CREATE TABLE events (
  id bigint NOT NULL, part integer NOT NULL,
  job text NOT NULL, kind text NOT NULL, data text NOT NULL, hint boolean NOT NULL)
  PARTITION BY LIST (part);
CREATE TABLE events_0 PARTITION OF events FOR VALUES IN (0);
CREATE TABLE events_1 PARTITION OF events FOR VALUES IN (1);
CREATE TABLE events_2 PARTITION OF events FOR VALUES IN (2);
CREATE TABLE events_3 PARTITION OF events FOR VALUES IN (3);
CREATE INDEX events_by_id ON events(id);
CREATE INDEX events_by_job ON events(job);

CREATE SEQUENCE table_numbers;
CREATE TABLE tables (
  number bigint PRIMARY KEY,
  id text NOT NULL UNIQUE,
  scene text NOT NULL, method text NOT NULL,
  parents text NOT NULL,                   -- ids, a line each
  created_ms bigint NOT NULL,
  bytes bigint NOT NULL, states bigint NOT NULL, samples_seen bigint NOT NULL,
  job text NOT NULL,
  geometry text NOT NULL, materials text NOT NULL, lights text NOT NULL);
CREATE INDEX tables_by_scene ON tables(method, geometry, materials, lights);

CREATE TABLE webhooks (
  id bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  url text NOT NULL, secret text NOT NULL, created_ms bigint NOT NULL,
  failures bigint NOT NULL DEFAULT 0, due_ms bigint NOT NULL DEFAULT 0,
  sender text, sends_until timestamptz);   -- the one process that tells it
CREATE TABLE deliveries (
  id bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  webhook bigint NOT NULL, job bigint NOT NULL, created_ms bigint NOT NULL);
CREATE INDEX deliveries_by_webhook ON deliveries(webhook, id);

CREATE TABLE workers (
  id text PRIMARY KEY, host text NOT NULL, kind text NOT NULL, build text NOT NULL,
  threads integer NOT NULL, started timestamptz NOT NULL, seen timestamptz NOT NULL,
  draining boolean NOT NULL DEFAULT false,
  samples bigint NOT NULL DEFAULT 0, samples_a_second double precision NOT NULL DEFAULT 0)
  WITH (fillfactor=40);
CREATE TABLE looked (one integer PRIMARY KEY, time_ms bigint NOT NULL) WITH (fillfactor=10);
)sql",
                                  R"sql(
-- Which bits a process makes, whom it helps, and why it was put aside.
ALTER TABLE workers ADD bits text NOT NULL DEFAULT '', ADD helps bigint,
  ADD aside text NOT NULL DEFAULT '';

-- Passes that several processes sample together. Nothing here outlives a crash of the database, nor
-- need it: what is missing is sampled again, to the same bits. So none of it is logged.
CREATE UNLOGGED TABLE shared_passes (
  job bigint PRIMARY KEY, claim bigint NOT NULL, pass bigint NOT NULL,
  bits text NOT NULL, workers integer NOT NULL,
  first integer NOT NULL, last integer NOT NULL, tiles integer NOT NULL,
  patience double precision NOT NULL, state bytea NOT NULL,
  guide_hash text NOT NULL, guide bytea);
CREATE UNLOGGED TABLE pass_units (
  job bigint, claim bigint, pass bigint, unit integer, worker text, given timestamptz,
  PRIMARY KEY (job, claim, pass, unit)) WITH (fillfactor=50);
CREATE UNLOGGED TABLE pass_results (
  job bigint, claim bigint, pass bigint, unit integer, worker text NOT NULL, hash text NOT NULL,
  sampled bytea NOT NULL, PRIMARY KEY (job, claim, pass, unit));
CREATE UNLOGGED TABLE pass_disputes (
  job bigint, claim bigint, pass bigint, unit integer, worker text, hash text NOT NULL,
  PRIMARY KEY (job, claim, pass, unit, worker));
CREATE UNLOGGED TABLE pass_helpers (
  job bigint, claim bigint NOT NULL, worker text, seen timestamptz NOT NULL,
  PRIMARY KEY (job, worker)) WITH (fillfactor=50);
-- Samples do not get smaller by packing.
ALTER TABLE shared_passes ALTER state SET STORAGE EXTERNAL, ALTER guide SET STORAGE EXTERNAL;
ALTER TABLE pass_results ALTER sampled SET STORAGE EXTERNAL;
)sql"};
constexpr int kVersion = std::size(kSteps);

}  // namespace

// A role that may not make tables can use those that are there.
Result<bool> prepare_pg_schema(PgDatabase& db) {
  {
    PgDatabase::Session session(db);
    Result<PgRows> there = session.run("SELECT to_regclass('qray_schema') IS NOT NULL");
    if (!there.ok()) return there.error();
    if (there.value().text(0, 0) == "t") {
      there = session.run("SELECT version FROM qray_schema");
      if (!there.ok()) return there.error();
      if (!there.value().empty() && there.value().integer(0, 0) == kVersion) return false;
    }
  }
  PgDatabase::Transaction transaction(db);
  // Two servers that start together.
  Result<PgRows> rows = transaction.run("SELECT pg_advisory_xact_lock(hashtext('qray schema'))");
  if (!rows.ok()) return rows.error();
  rows = transaction.run(
      "CREATE TABLE IF NOT EXISTS qray_schema(one integer PRIMARY KEY, version integer NOT NULL)");
  if (!rows.ok()) return rows.error();
  rows = transaction.run("SELECT version FROM qray_schema");
  if (!rows.ok()) return rows.error();
  const bool is_new = rows.value().empty();
  const int64_t found = is_new ? 0 : rows.value().integer(0, 0);
  if (found < 0 || found > kVersion)
    return Error{ErrorCode::kUnsupported,
                 "the database has schema version " + std::to_string(found) +
                     ", expected at most " + std::to_string(kVersion),
                 ""};
  for (int64_t version = found; version < kVersion; ++version)
    if (Status made = transaction.run_all(kSteps[version]); !made.ok()) return made.error();
  rows = transaction.run(
      "INSERT INTO qray_schema VALUES(1, $1) ON CONFLICT(one) DO UPDATE SET version=$1",
      {kVersion});
  if (!rows.ok()) return rows.error();
  if (Status s = transaction.commit(); !s.ok()) return s.error();
  return is_new;
}

}  // namespace qray::server
