#include "server/postgres/pg_shared_passes.h"

namespace qray::server {
namespace {

// Of those who take part: who is not heard of for so long is not counted.
constexpr double kSilentSeconds = 10;
constexpr int kUnitsAtOnce = 16;  // collected

std::string array(std::span<const size_t> numbers) {
  std::string text = "{";
  for (const size_t n : numbers) text += (text.size() > 1 ? "," : "") + std::to_string(n);
  return text + "}";
}

Bytes bytes_of(const PgRows& rows, int row, int column) {
  const std::string text = rows.text(row, column);
  return {text.begin(), text.end()};
}

}  // namespace

// The units of passes before go, in the same statement: only where this process has the job, for
// one that slept would otherwise delete the units of the process that has it now. Deleted rows and
// new ones differ in their keys, so it does not matter which part is carried out first.
Status PgSharedPasses::begin(const Pass& pass, const std::string& bits, int workers,
                             const Bytes* guide) {
  PgDatabase::Session session(db_);
  const Cut& cut = pass.cut;
  const Result<PgRows> rows = session.run(
      "WITH mine AS (SELECT job FROM runs WHERE job=$1 AND claim=$2 AND worker=$4), "
      "old_units AS (DELETE FROM pass_units o USING mine WHERE o.job=mine.job AND "
      "(o.claim, o.pass) <> ($2, $3)), "
      "old_results AS (DELETE FROM pass_results o USING mine WHERE o.job=mine.job AND "
      "(o.claim, o.pass) <> ($2, $3)), "
      "old_disputes AS (DELETE FROM pass_disputes o USING mine WHERE o.job=mine.job AND "
      "(o.claim, o.pass) <> ($2, $3)), "
      "begun AS (INSERT INTO shared_passes(job, claim, pass, bits, workers, first, last, tiles, "
      "patience, state, guide_hash, guide) SELECT job, $2, $3, $5, $6, $7, $8, $9, $10, $11, $12, "
      "$13 FROM mine ON CONFLICT(job) DO UPDATE SET claim=$2, pass=$3, bits=$5, workers=$6, "
      "first=$7, last=$8, tiles=$9, patience=$10, state=$11, guide_hash=$12, "
      "guide=coalesce(excluded.guide, shared_passes.guide)), "
      "units AS (INSERT INTO pass_units(job, claim, pass, unit) SELECT job, $2, $3, n FROM mine, "
      "generate_series(0, $14::int - 1) AS n ON CONFLICT DO NOTHING) "
      "SELECT job FROM mine",
      {pass.key.job.value, pass.key.claim, pass.key.pass, worker_, bits, workers, cut.first,
       cut.end, cut.tiles_a_unit, pass.patience, PgValue(pass.state), pass.guide,
       guide ? PgValue(*guide) : PgValue(std::nullopt), cut.units()});
  if (!rows.ok()) return rows.error();
  if (rows.value().empty())
    return Error{ErrorCode::kCanceled, "another process may have the job by now", ""};
  return {};
}

Result<SharedPasses::Collected> PgSharedPasses::collect(const Key& key,
                                                        std::span<const size_t> here) {
  PgDatabase::Session session(db_);
  const Result<PgRows> rows = session.run_bytes(
      "SELECT r.unit::text, r.worker, r.hash, r.sampled, r.disputed::text FROM shared_passes p "
      "LEFT JOIN ((SELECT unit, worker, hash, sampled, false AS disputed FROM pass_results "
      "WHERE job=$1 AND claim=$2 AND pass=$3 AND unit <> ALL($4::int[]) AND worker <> $5 "
      "ORDER BY unit LIMIT $6) UNION ALL "
      "(SELECT unit, worker, hash, NULL, true FROM pass_disputes WHERE job=$1 AND claim=$2 AND "
      "pass=$3) UNION ALL (SELECT unit, worker, hash, NULL, true FROM pass_results WHERE job=$1 "
      "AND claim=$2 AND pass=$3 AND unit IN (SELECT unit FROM pass_disputes WHERE job=$1 AND "
      "claim=$2 AND pass=$3))) r ON true WHERE p.job=$1 AND p.claim=$2 AND p.pass=$3",
      {key.job.value, key.claim, key.pass, array(here), worker_, kUnitsAtOnce});
  if (!rows.ok()) return rows.error();
  const PgRows& r = rows.value();
  Collected collected;
  collected.there = !r.empty();
  for (int row = 0; row < r.size(); ++row) {
    if (r.is_null(row, 0)) continue;
    Unit unit{r.number(row, 0), r.text(row, 1), r.text(row, 2), bytes_of(r, row, 3)};
    (r.text(row, 4) == "true" ? collected.disputed : collected.units).push_back(std::move(unit));
  }
  return collected;
}

Status PgSharedPasses::reopen(const Key& key, std::span<const size_t> units) {
  PgDatabase::Session session(db_);
  return session.change(
      "WITH results AS (DELETE FROM pass_results WHERE job=$1 AND claim=$2 AND pass=$3 AND "
      "unit = ANY($4::int[])) UPDATE pass_units SET worker=NULL, given=NULL WHERE job=$1 AND "
      "claim=$2 AND pass=$3 AND unit = ANY($4::int[])",
      {key.job.value, key.claim, key.pass, array(units)});
}

Status PgSharedPasses::end(JobId job, uint64_t claim) {
  PgDatabase::Session session(db_);
  return session.change(
      "WITH ended AS (DELETE FROM shared_passes WHERE job=$1 AND claim <= $2), "
      "units AS (DELETE FROM pass_units WHERE job=$1 AND claim <= $2), "
      "results AS (DELETE FROM pass_results WHERE job=$1 AND claim <= $2), "
      "disputes AS (DELETE FROM pass_disputes WHERE job=$1 AND claim <= $2) "
      "DELETE FROM pass_helpers WHERE job=$1 AND claim <= $2",
      {job.value, claim});
}

// Of a run that is not lost; first one that has few helpers.
Result<std::optional<SharedPasses::Open>> PgSharedPasses::find(const std::string& bits) {
  PgDatabase::Session session(db_);
  const Result<PgRows> rows = session.run(
      "SELECT p.job, p.claim FROM shared_passes p JOIN runs ON runs.job=p.job AND "
      "runs.claim=p.claim AND runs.until > clock_timestamp() AND runs.worker <> $2 "
      "CROSS JOIN LATERAL (SELECT count(*) AS n FROM pass_helpers h WHERE h.job=p.job AND "
      "h.claim=p.claim AND h.seen > clock_timestamp() - make_interval(secs => $3)) helpers "
      "WHERE p.bits=$1 AND (p.workers=0 OR helpers.n < p.workers - 1) "
      "AND NOT EXISTS (SELECT FROM workers w WHERE w.id=$2 AND w.aside <> '') "
      "ORDER BY helpers.n, p.job LIMIT 1",
      {bits, worker_, kSilentSeconds});
  if (!rows.ok()) return rows.error();
  if (rows.value().empty()) return std::optional<Open>();
  return std::optional(Open{{rows.value().number(0, 0)}, rows.value().number(0, 1)});
}

// One at a time, so that there are not too many.
Result<bool> PgSharedPasses::join(const Open& job) {
  PgDatabase::Transaction transaction(db_);
  const Result<PgRows> there =
      transaction.run("SELECT workers FROM shared_passes WHERE job=$1 AND claim=$2 FOR UPDATE",
                      {job.job.value, job.claim});
  if (!there.ok()) return there.error();
  if (there.value().empty()) return false;
  const Result<PgRows> joined = transaction.run(
      "INSERT INTO pass_helpers(job, claim, worker, seen) SELECT $1, $2, $3, clock_timestamp() "
      "WHERE $4 = 0 OR (SELECT count(*) FROM pass_helpers WHERE job=$1 AND claim=$2 AND "
      "worker <> $3 AND seen > clock_timestamp() - make_interval(secs => $5)) < $4 - 1 "
      "ON CONFLICT(job, worker) DO UPDATE SET claim=$2, seen=excluded.seen RETURNING job",
      {job.job.value, job.claim, worker_, there.value().integer(0, 0), kSilentSeconds});
  if (!joined.ok()) return joined.error();
  if (Status s = transaction.commit_soon(); !s.ok()) return s.error();
  return !joined.value().empty();
}

Status PgSharedPasses::leave(const Open& job) {
  PgDatabase::Session session(db_);
  return session.change("DELETE FROM pass_helpers WHERE job=$1 AND worker=$2",
                        {job.job.value, worker_});
}

Result<std::optional<SharedPasses::Pass>> PgSharedPasses::next(const Open& job,
                                                               const std::optional<Key>& than) {
  PgDatabase::Session session(db_);
  const Result<PgRows> rows = session.run_bytes(
      "SELECT pass::text, first::text, last::text, tiles::text, patience::text, guide_hash, state "
      "FROM shared_passes WHERE job=$1 AND claim=$2 AND pass <> $3",
      {job.job.value, job.claim, than ? than->pass : int64_t{-1}});
  if (!rows.ok()) return rows.error();
  const PgRows& r = rows.value();
  std::optional<Pass> pass;
  if (r.empty()) return pass;
  pass.emplace();
  pass->key = {job.job, job.claim, r.integer(0, 0)};
  pass->cut = {r.number(0, 1), r.number(0, 2), std::max<size_t>(r.number(0, 3), 1)};
  pass->patience = r.real(0, 4);
  pass->guide = r.text(0, 5);
  pass->state = bytes_of(r, 0, 6);
  return pass;
}

Result<Bytes> PgSharedPasses::load_guide(const Open& job, const std::string& guide) {
  PgDatabase::Session session(db_);
  const Result<PgRows> rows = session.run_bytes(
      "SELECT guide FROM shared_passes WHERE job=$1 AND claim=$2 AND guide_hash=$3 AND guide IS "
      "NOT NULL",
      {job.job.value, job.claim, guide});
  if (!rows.ok()) return rows.error();
  if (rows.value().empty())
    return Error{ErrorCode::kNotFound, "this guide is not the pass's any more", ""};
  return bytes_of(rows.value(), 0, 0);
}

Result<std::optional<size_t>> PgSharedPasses::take(const Key& key, double patience) {
  PgDatabase::Session session(db_);
  const Result<PgRows> rows = session.run(
      "WITH heard AS (UPDATE pass_helpers SET seen=clock_timestamp() WHERE job=$1 AND worker=$4 "
      "AND seen < clock_timestamp() - interval '1 s'), "
      "open AS MATERIALIZED (SELECT unit FROM pass_units u WHERE job=$1 AND claim=$2 AND pass=$3 "
      "AND (worker IS NULL OR given < clock_timestamp() - make_interval(secs => $5)) "
      "AND NOT EXISTS (SELECT FROM pass_results r WHERE r.job=$1 AND r.claim=$2 AND r.pass=$3 AND "
      "r.unit=u.unit) ORDER BY worker IS NOT NULL, given, unit LIMIT 1 FOR UPDATE SKIP LOCKED) "
      "UPDATE pass_units u SET worker=$4, given=clock_timestamp() FROM open WHERE u.job=$1 AND "
      "u.claim=$2 AND u.pass=$3 AND u.unit=open.unit RETURNING u.unit",
      {key.job.value, key.claim, key.pass, worker_, patience});
  if (!rows.ok()) return rows.error();
  if (rows.value().empty()) return std::optional<size_t>();
  return std::optional<size_t>(rows.value().number(0, 0));
}

Result<SharedPasses::Put> PgSharedPasses::put(const Key& key, const Unit& unit) {
  PgDatabase::Session session(db_);
  const Result<PgRows> rows = session.run(
      "WITH pass AS (SELECT job FROM shared_passes WHERE job=$1 AND claim=$2 AND pass=$3 AND NOT "
      "EXISTS (SELECT FROM workers w WHERE w.id=$5 AND w.aside <> '')), "
      "put AS (INSERT INTO pass_results(job, claim, pass, unit, worker, hash, sampled) "
      "SELECT job, $2, $3, $4, $5, $6, $7 FROM pass ON CONFLICT DO NOTHING RETURNING unit), "
      "first AS (SELECT hash, worker FROM pass_results WHERE job=$1 AND claim=$2 AND pass=$3 AND "
      "unit=$4), "
      "dispute AS (INSERT INTO pass_disputes(job, claim, pass, unit, worker, hash) "
      "SELECT job, $2, $3, $4, $5, $6 FROM pass, first WHERE first.hash <> $6 "
      "ON CONFLICT DO NOTHING) "
      "SELECT EXISTS(SELECT FROM pass), EXISTS(SELECT FROM put), "
      "EXISTS(SELECT FROM first WHERE hash <> $6)",
      {key.job.value, key.claim, key.pass, unit.unit, worker_, unit.hash, PgValue(unit.sampled)});
  if (!rows.ok()) return rows.error();
  const auto is = [&](int column) { return rows.value().text(0, column) == "t"; };
  if (!is(0)) return Put::kLate;
  if (is(1)) return Put::kTaken;
  return is(2) ? Put::kDiffers : Put::kTwice;
}

Status PgSharedPasses::put_aside(const std::string& worker, const std::string& why) {
  PgDatabase::Session session(db_);
  return session.change("UPDATE workers SET draining=true, aside=$2 WHERE id=$1 AND aside=''",
                        {worker, why});
}

Result<int> PgSharedPasses::others_of_other_bits(const std::string& bits) {
  PgDatabase::Session session(db_);
  const Result<PgRows> rows = session.run(
      "SELECT count(*) FROM workers WHERE bits <> $1 AND threads > 0 AND "
      "seen > clock_timestamp() - interval '1 min'",
      {bits});
  if (!rows.ok()) return rows.error();
  return static_cast<int>(rows.value().integer(0, 0));
}

}  // namespace qray::server
