// The list of jobs, by its filters.
#include <algorithm>

#include "server/sqlite/job_row.h"
#include "server/sqlite/sqlite_job_store.h"

namespace qray::server {

Result<std::vector<JobRecord>> SqliteJobStore::list(size_t limit, const Filter& filter) const {
  // Each filter has an index that holds its jobs by id. Of several, the one that is likely to hold
  // the fewest is walked through, and the others are asked about each of its jobs: most jobs have
  // succeeded, so that states without that one come first.
  const auto has_succeeded = [&] {
    return std::find(filter.states.begin(), filter.states.end(), JobState::kSucceeded) !=
           filter.states.end();
  };
  const bool by_state =
      !filter.states.empty() && ((!filter.table && filter.labels.empty()) || !has_succeeded());
  const bool by_table = !by_state && filter.table;
  const bool by_label = !by_state && !by_table && !filter.labels.empty();
  // Numbered parameters: ?1 ids below, ?2 limit, ?3 table, then states, then labels, then the
  // bounds of times.
  constexpr size_t kFirstState = 4;
  const auto parameter = [](size_t number) { return "?" + std::to_string(number); };
  const auto state_at = [&](size_t i) { return parameter(kFirstState + i); };
  const auto label_at = [&](size_t i) {
    const size_t name = kFirstState + filter.states.size() + 2 * i;
    return "name=" + parameter(name) + " AND value=" + parameter(name + 1);
  };
  std::string others;  // a + keeps a column's index out of it
  if (filter.table && !by_table) others += " AND (+table_in=?3 OR +table_out=?3)";
  if (!filter.states.empty() && !by_state) {
    others += " AND +state IN (";
    for (size_t i = 0; i < filter.states.size(); ++i) others += (i > 0 ? "," : "") + state_at(i);
    others += ")";
  }
  for (size_t i = by_label ? 1 : 0; i < filter.labels.size(); ++i)
    others += " AND EXISTS(SELECT 1 FROM job_labels WHERE job=jobs.id AND " + label_at(i) + ")";
  // The times are read from an index that has them in the order of the ids, and not from the rows,
  // which are larger.
  std::string times;
  const size_t first_time = kFirstState + filter.states.size() + 2 * filter.labels.size();
  const std::pair<const char*, std::optional<int64_t>> bounds[] = {
      {"created_ms>=", filter.created.from},
      {"created_ms<", filter.created.before},
      {"ended_ms>=", filter.ended.from},
      {"ended_ms<", filter.ended.before}};
  for (size_t i = 0; i < std::size(bounds); ++i)
    if (bounds[i].second) times += " AND t." + (bounds[i].first + parameter(first_time + i));
  const bool by_time = !times.empty() && !by_state && !by_table && !by_label;
  if (!times.empty() && !by_time)
    others += " AND EXISTS(SELECT 1 FROM jobs AS t INDEXED BY jobs_by_times WHERE t.id=jobs.id" +
              times + ")";
  std::string ids;
  const auto add = [&](const std::string& from_where, const char* id = "id") {
    ids += (ids.empty() ? "" : " UNION ") +
           ("SELECT id FROM (SELECT id FROM " + from_where + " AND " + id + "<?1" + others +
            " ORDER BY " + id + " DESC LIMIT ?2)");
  };
  if (by_state) {
    for (size_t i = 0; i < filter.states.size(); ++i) add("jobs WHERE state=" + state_at(i));
  } else if (by_table) {
    for (const std::string column : {"table_in", "table_out"})
      add("jobs WHERE " + column + "=?3 AND " + column + "<>''");
  } else if (by_label) {
    add("job_labels CROSS JOIN jobs ON id=job WHERE " + label_at(0), "job");
  }
  if (by_time)
    ids = "SELECT id FROM jobs AS t INDEXED BY jobs_by_times WHERE id<?1" + times +
          " ORDER BY id DESC LIMIT ?2";
  const std::string sql = std::string("SELECT ") + kJobColumns + " FROM jobs WHERE id<?1 AND " +
                          (ids.empty() ? "1" : "id IN (" + ids + ")") +
                          " ORDER BY id DESC LIMIT ?2";
  const Database::Reading reading(db_);
  Query query(reading.handle(), sql.c_str());
  query.bind(filter.before ? static_cast<int64_t>(filter.before->value) : INT64_MAX);
  query.bind(static_cast<int64_t>(limit));
  query.bind(filter.table);
  for (const JobState state : filter.states) query.bind(std::string(to_string(state)));
  for (const auto& [name, value] : filter.labels) query.bind(name).bind(value);
  if (!times.empty())
    for (const auto& [column, bound] : bounds) query.bind(bound);
  std::vector<JobRecord> jobs;
  while (query.next()) jobs.push_back(read_job(query));
  if (Status s = query.status(); !s.ok()) return s.error();
  return jobs;
}

}  // namespace qray::server
