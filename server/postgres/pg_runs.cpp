// Who runs which job: claims, leases, and the processes that do it.
#include <spdlog/spdlog.h>

#include <sstream>

#include "server/postgres/pg_job_row.h"
#include "server/postgres/pg_job_store.h"

namespace qray::server {
namespace {

constexpr int kLostAtOnce = 100;
constexpr int64_t kKeysAtOnce = 1'000;

// The values of a column, for unnest().
template <class Of>
std::string array(std::span<const SharedJobs::Run> runs, const Of& of) {
  std::string text = "{";
  for (const SharedJobs::Run& run : runs) text += (text.size() > 1 ? "," : "") + of(run);
  return text + "}";
}

}  // namespace

Status PgJobStore::write_run(Transaction& transaction, const JobRecord& job) {
  if (job.state == JobState::kPreparing)
    return transaction.change(
        "INSERT INTO runs(job, claim, worker, until) "
        "VALUES($1,$2,$3, clock_timestamp() + make_interval(secs => $4)) ON CONFLICT(job) DO "
        "UPDATE SET claim=$2, worker=$3, until=excluded.until, fraction=0, samples=0, seconds=0",
        {job.id.value, job.claim, worker_, lease_seconds()});
  if (is_running(job.state)) return {};
  return transaction.change("DELETE FROM runs WHERE job=$1", {job.id.value});
}

// Locks the row of the job, and of the others none: claimers skip what another one has locked.
// MATERIALIZED, so that it is looked for once.
Result<std::optional<JobRecord>> PgJobStore::claim(bool suspects_too) {
  std::optional<JobRecord> claimed;
  {
    Transaction transaction(db_);
    const Result<PgRows> rows = transaction.run(
        "WITH next AS MATERIALIZED (SELECT id FROM jobs WHERE state='queued' AND attempts < $1 "
        "ORDER BY rank, id LIMIT 1 FOR UPDATE SKIP LOCKED), "
        "claimed AS (UPDATE jobs SET state='preparing', started_ms=$2, attempts=attempts+1, "
        "claim=claim+1 FROM next WHERE jobs.id=next.id RETURNING jobs.*), "
        "run AS (INSERT INTO runs(job, claim, worker, until) SELECT id, claim, $3, "
        "clock_timestamp() + make_interval(secs => $4) FROM claimed ON CONFLICT(job) DO UPDATE SET "
        "claim=excluded.claim, worker=excluded.worker, until=excluded.until, fraction=0, "
        "samples=0, seconds=0) "
        "SELECT " +
            std::string(kPgJobColumns) + " FROM claimed AS jobs LEFT JOIN runs ON false",
        {suspects_too ? INT32_MAX : kMaxAttempts - 1, now_ms_(), worker_, lease_seconds()});
    if (!rows.ok()) return rows.error();
    if (rows.value().empty()) return claimed;
    claimed = read_pg_job(rows.value(), 0);
    if (Status s = write_log(transaction, claimed->id, "info", to_string(claimed->state)); !s.ok())
      return s.error();
    if (Status s = write_event(transaction, state_event_of(*claimed)); !s.ok()) return s.error();
    if (Status s = transaction.commit(); !s.ok()) return s.error();
  }
  publish_new();
  return claimed;
}

Result<std::vector<PgJobStore::Held>> PgJobStore::renew(std::span<const Run> runs) {
  std::vector<Held> held;
  if (runs.empty()) return held;
  const auto number = [&](auto of) {
    return array(runs, [&](const Run& run) { return std::to_string(of(run)); });
  };
  const auto real = [&](auto of) {
    return array(runs, [&](const Run& run) { return std::string(PgValue(of(run)).text()); });
  };
  Transaction transaction(db_);
  const Result<PgRows> rows = transaction.run(
      "WITH mine AS (SELECT * FROM unnest($2::bigint[], $3::bigint[], $4::float8[], $5::bigint[], "
      "$6::float8[]) AS m(job, claim, fraction, samples, seconds)), "
      "renewed AS (UPDATE runs SET until=clock_timestamp() + make_interval(secs => $7), "
      "fraction=mine.fraction, samples=mine.samples, seconds=mine.seconds FROM mine "
      "WHERE runs.job=mine.job AND runs.claim=mine.claim AND runs.worker=$1 RETURNING runs.job) "
      "SELECT jobs.id, jobs.state FROM renewed JOIN jobs ON jobs.id=renewed.job",
      {worker_, number([](const Run& run) { return run.id.value; }),
       number([](const Run& run) { return run.claim; }),
       real([](const Run& run) { return run.progress.fraction; }),
       number([](const Run& run) { return run.progress.samples; }),
       real([](const Run& run) { return run.progress.seconds; }), lease_seconds()});
  if (!rows.ok()) return rows.error();
  for (int row = 0; row < rows.value().size(); ++row)
    if (const auto state = parse_job_state(rows.value().text(row, 1)))
      held.push_back({{rows.value().number(row, 0)}, *state});
  if (Status s = transaction.commit(); !s.ok()) return s.error();
  return held;
}

Result<std::vector<JobId>> PgJobStore::take_up_lost() {
  if (Status s = take_up_all_lost(); !s.ok()) return s.error();
  std::lock_guard lock(lost_mutex_);
  return std::exchange(lost_, {});
}

Status PgJobStore::take_up_all_lost() {
  std::vector<JobId> lost;
  {
    Transaction transaction(db_);
    const Result<PgRows> rows = transaction.run(
        "SELECT job FROM runs WHERE until < clock_timestamp() ORDER BY job LIMIT $1",
        {kLostAtOnce});
    if (!rows.ok()) return rows.error();
    lost = pg_ids(rows.value());
    if (Status s = transaction.change(
            "DELETE FROM idempotency_keys WHERE key IN (SELECT key FROM idempotency_keys WHERE "
            "created_ms<=$1 LIMIT $2 FOR UPDATE SKIP LOCKED)",
            {now_ms_() - kIdempotencyKeyMs, kKeysAtOnce});
        !s.ok())
      return s;
    if (Status s = transaction.change(
            "DELETE FROM workers WHERE seen < clock_timestamp() - interval '1 hour'");
        !s.ok())
      return s;
    if (Status s = transaction.commit(); !s.ok()) return s;
  }
  for (const JobId id : lost) {
    const Result<std::optional<JobRecord>> job = take_up(id);
    if (job.ok()) {
      std::lock_guard lock(lost_mutex_);
      lost_.push_back(id);
      spdlog::warn("job={} its worker is silent{}", id.text(),
                   job.value() ? ": it is queued again" : "");
    } else if (job.error().code == ErrorCode::kIo) {
      return job.error();
    }  // else another process was first
  }
  return {};
}

Result<std::vector<JobRecord>> PgJobStore::recover() {
  if (Status s = restore_events(); !s.ok()) return s.error();
  if (Status s = take_up_all_lost(); !s.ok()) return s.error();
  PgDatabase::Session session(db_);
  const Result<PgRows> rows = session.run(std::string("SELECT ") + kPgJobColumns + " FROM " +
                                          kPgJobTables + " WHERE state='queued' ORDER BY jobs.id");
  if (!rows.ok()) return rows.error();
  std::vector<JobRecord> queued;
  for (int row = 0; row < rows.value().size(); ++row) {
    JobRecord job = read_pg_job(rows.value(), row);
    if (!job.damaged) {
      queued.push_back(std::move(job));
    } else if (Status s = fail_damaged(job); !s.ok()) {
      return s.error();
    }
  }
  return queued;
}

Result<bool> PgJobStore::present(const WorkerInfo& me) {
  Transaction transaction(db_);
  const Result<PgRows> row = transaction.run(
      "INSERT INTO workers(id, host, kind, build, threads, started, seen, samples, "
      "samples_a_second, bits, helps) VALUES($1,$2,$3,$4,$5, clock_timestamp(), "
      "clock_timestamp(), $6, $7, $8, $9) ON CONFLICT(id) DO UPDATE SET seen=clock_timestamp(), "
      "samples=$6, samples_a_second=$7, helps=$9 RETURNING draining",
      {worker_, host_, me.kind, me.build, me.threads, me.samples, me.samples_a_second, me.bits,
       me.helps ? PgValue(me.helps->value) : PgValue(std::nullopt)});
  if (!row.ok()) return row.error();
  if (Status s = transaction.commit_soon(); !s.ok()) return s.error();
  return row.value().text(0, 0) != "t";
}

Status PgJobStore::leave() {
  Transaction transaction(db_);
  if (Status s = transaction.change("DELETE FROM workers WHERE id=$1", {worker_}); !s.ok())
    return s;
  return transaction.commit();
}

Result<std::vector<WorkerInfo>> PgJobStore::workers() const {
  PgDatabase::Session session(db_);
  const Result<PgRows> rows = session.run(
      "SELECT id, host, kind, build, threads, draining, samples, samples_a_second, "
      "extract(epoch FROM clock_timestamp() - started), "
      "extract(epoch FROM clock_timestamp() - seen), "
      "(SELECT string_agg(job::text, ' ' ORDER BY job) FROM runs WHERE worker=workers.id), "
      "bits, helps, aside "
      "FROM workers ORDER BY started, id");
  if (!rows.ok()) return rows.error();
  const PgRows& r = rows.value();
  std::vector<WorkerInfo> workers;
  for (int row = 0; row < r.size(); ++row) {
    WorkerInfo info;
    info.id = r.text(row, 0);
    info.host = r.text(row, 1);
    info.kind = r.text(row, 2);
    info.build = r.text(row, 3);
    info.threads = static_cast<int>(r.integer(row, 4));
    info.draining = r.text(row, 5) == "t";
    info.samples = r.number(row, 6);
    info.samples_a_second = r.real(row, 7);
    info.age_seconds = r.real(row, 8);
    info.silent_seconds = r.real(row, 9);
    info.bits = r.text(row, 11);
    if (!r.is_null(row, 12)) info.helps = JobId{r.number(row, 12)};
    info.aside = r.text(row, 13);
    std::istringstream jobs(r.text(row, 10));
    for (uint64_t job; jobs >> job;) info.jobs.push_back({job});
    workers.push_back(std::move(info));
  }
  return workers;
}

Status PgJobStore::drain(const std::string& worker) {
  {
    Transaction transaction(db_);
    const Result<PgRows> row =
        transaction.run("UPDATE workers SET draining=true WHERE id=$1 RETURNING id", {worker});
    if (!row.ok()) return row.error();
    if (row.value().empty()) return Error{ErrorCode::kNotFound, "no worker " + worker, ""};
    if (Status s = transaction.commit(); !s.ok()) return s;
  }
  tell_others();
  return {};
}

}  // namespace qray::server
