// What is asked of many jobs.
#include "server/postgres/pg_job_row.h"
#include "server/postgres/pg_job_store.h"

namespace qray::server {
namespace {

// What is searched for words.
std::string searched() {
  return "lower('j'||lpad(jobs.id::text,greatest(6,length(jobs.id::text)),'0')||' '||jobs.scene||' "
         "'||"
         "coalesce(substring(request from '\"method\":\"([^\"]*)\"'),'" +
         JobRequest().get(field::kMethod) +
         "')||' '||replace(replace(labels::text,'\": \"',':'),'\"',''))";
}

}  // namespace

Result<std::vector<JobRecord>> PgJobStore::list(size_t limit, const Filter& filter) const {
  std::string where = "true";
  std::vector<PgValue> values;
  const auto value = [&](PgValue v) {
    values.push_back(std::move(v));
    return "$" + std::to_string(values.size());
  };
  if (filter.before) where += " AND jobs.id<" + value(filter.before->value);
  if (!filter.states.empty()) {
    where += " AND state IN (";
    for (size_t i = 0; i < filter.states.size(); ++i)
      where += (i > 0 ? "," : "") + value(to_string(filter.states[i]));
    where += ")";
  }
  for (const auto& [name, of] : filter.labels)
    where +=
        " AND labels @> jsonb_build_object(" + value(name) + "::text, " + value(of) + "::text)";
  if (filter.table) {
    const std::string table = value(*filter.table);
    where += " AND (table_in=" + table + " OR table_out=" + table + ")";
  }
  const std::pair<const char*, std::optional<int64_t>> bounds[] = {
      {"created_ms>=", filter.created.from},
      {"created_ms<", filter.created.before},
      {"ended_ms>=", filter.ended.from},
      {"ended_ms<", filter.ended.before}};
  for (const auto& [column, bound] : bounds)
    if (bound) where += std::string(" AND ") + column + value(*bound);
  for (const auto& [text, scenes] : filter.words)
    where += std::string(" AND (strpos(") + searched() + "," + value(text) + ")>0 OR strpos(" +
             value(scenes) + ",','||jobs.scene||',')>0)";
  PgDatabase::Session session(db_);
  const Result<PgRows> rows =
      session.run(std::string("SELECT ") + kPgJobColumns + " FROM " + kPgJobTables + " WHERE " +
                      where + " ORDER BY jobs.id DESC LIMIT " + value(uint64_t{limit}),
                  values);
  if (!rows.ok()) return rows.error();
  std::vector<JobRecord> jobs;
  for (int row = 0; row < rows.value().size(); ++row)
    jobs.push_back(read_pg_job(rows.value(), row));
  return jobs;
}

Result<std::vector<JobId>> PgJobStore::open() const {
  PgDatabase::Session session(db_);
  const Result<PgRows> rows = session.run(
      "SELECT id FROM jobs WHERE state NOT IN ('succeeded','canceled','failed') ORDER BY id");
  if (!rows.ok()) return rows.error();
  return pg_ids(rows.value());
}

Result<std::vector<JobId>> PgJobStore::ended_before(int64_t ms, size_t limit) const {
  PgDatabase::Session session(db_);
  const Result<PgRows> rows = session.run(
      "SELECT id FROM jobs WHERE state IN ('succeeded','canceled','failed') AND ended_ms<$1 "
      "ORDER BY id LIMIT $2",
      {ms, uint64_t{limit}});
  if (!rows.ok()) return rows.error();
  return pg_ids(rows.value());
}

Result<PgJobStore::Ids> PgJobStore::ids() const {
  PgDatabase::Session session(db_);
  const Result<PgRows> there = session.run("SELECT id FROM jobs ORDER BY id");
  if (!there.ok()) return there.error();
  const Result<PgRows> newest =
      session.run("SELECT CASE WHEN is_called THEN last_value ELSE 0 END FROM job_ids");
  if (!newest.ok()) return newest.error();
  return Ids{pg_ids(there.value()), {newest.value().number(0, 0)}};
}

Status PgJobStore::give_no_id_up_to(JobId id) {
  Transaction transaction(db_);
  if (Status s = transaction.change(
          "SELECT setval('job_ids', greatest($1, (SELECT last_value FROM job_ids)))", {id.value});
      !s.ok())
    return s;
  return transaction.commit();
}

Result<size_t> PgJobStore::queued() const {
  PgDatabase::Session session(db_);
  const Result<PgRows> rows = session.run("SELECT count(*) FROM jobs WHERE state='queued'");
  if (!rows.ok()) return rows.error();
  return size_t{rows.value().number(0, 0)};
}

Result<PgJobStore::Counts> PgJobStore::count() const {
  PgDatabase::Session session(db_);
  const Result<PgRows> rows = session.run(
      "SELECT state, count(*), min(created_ms) FILTER (WHERE state='queued') FROM jobs "
      "GROUP BY state");
  if (!rows.ok()) return rows.error();
  Counts counts;
  for (int row = 0; row < rows.value().size(); ++row) {
    const auto state = parse_job_state(rows.value().text(row, 0));
    if (!state) continue;
    counts.by_state[*state] = rows.value().number(row, 1);
    if (!rows.value().is_null(row, 2)) counts.oldest_queued_ms = rows.value().integer(row, 2);
  }
  return counts;
}

}  // namespace qray::server
