// The list of jobs, by its filters.
#include <algorithm>

#include "server/sqlite/job_row.h"
#include "server/sqlite/sqlite_job_store.h"

namespace qray::server {
namespace {

constexpr int64_t kMany = 1000;

// Of a row that can be read: what is searched for words, and the scene.
std::string searched() {
  return "lower(printf('j%06d ',jobs.id)||json_extract(jobs.request,'$.scene')||' '||"
         "coalesce(json_extract(jobs.request,'$.method'),'" +
         JobRequest().get(field::kMethod) +
         "')||' '||replace(coalesce(json_extract(jobs.request,'$.labels'),''),'\"',''))";
}
constexpr const char* kScene = "','||json_extract(jobs.request,'$.scene')||','";

// How many rows there are; kMany: as many or more.
int64_t count_few(sqlite3* db, const std::string& from_where,
                  const std::vector<std::string>& values) {
  const std::string sql =
      "SELECT COUNT(*) FROM (SELECT 1 FROM " + from_where + " LIMIT " + std::to_string(kMany) + ")";
  Query query(db, sql.c_str());
  for (const std::string& value : values) query.bind(value);
  return query.next() ? query.integer(0) : kMany;
}

// Each filter has an index that holds its jobs by id. Of several, the one that holds the fewest is
// walked through, and the others are asked about each of its jobs.
enum class Walk { kIds, kStates, kTable, kLabel, kTimes };

// The rarest label comes first.
Walk choose_walk(sqlite3* db, JobStore::Filter& filter, bool has_times) {
  const size_t filters = (filter.states.empty() ? 0u : 1u) + (filter.table ? 1u : 0u) +
                         filter.labels.size() + (has_times ? 1u : 0u);
  if (filters == 0) return Walk::kIds;
  Walk walk = has_times ? Walk::kTimes : Walk::kIds;
  int64_t fewest = has_times ? kMany : INT64_MAX;
  const auto offer = [&](Walk other, const auto& count) {
    const int64_t jobs = filters > 1 ? count() : 0;
    if (jobs >= fewest) return false;
    walk = other;
    fewest = jobs;
    return true;
  };
  for (size_t i = 0; i < filter.labels.size(); ++i) {
    const auto& [name, value] = filter.labels[i];
    if (offer(Walk::kLabel, [&] {
          return count_few(db, "job_labels WHERE name=? AND value=?", {name, value});
        }))
      std::swap(filter.labels[0], filter.labels[i]);
  }
  if (filter.table)
    offer(Walk::kTable, [&] {
      return count_few(db, "jobs WHERE table_in=? AND table_in<>''", {*filter.table}) +
             count_few(db, "jobs WHERE table_out=? AND table_out<>''", {*filter.table});
    });
  if (!filter.states.empty())
    offer(Walk::kStates, [&] {
      int64_t jobs = 0;
      for (const JobState state : filter.states)
        jobs += count_few(db, "jobs WHERE state=?", {std::string(to_string(state))});
      return jobs;
    });
  return walk;
}

}  // namespace

Result<std::vector<JobRecord>> SqliteJobStore::list(size_t limit, const Filter& asked) const {
  const Database::Reading reading(db_);
  Filter filter = asked;
  const bool has_times =
      filter.created.from || filter.created.before || filter.ended.from || filter.ended.before;
  const Walk walk = choose_walk(reading.handle(), filter, has_times);
  const bool by_state = walk == Walk::kStates, by_table = walk == Walk::kTable,
             by_label = walk == Walk::kLabel, by_time = walk == Walk::kTimes;
  // Numbered parameters: ?1 ids below, ?2 limit, ?3 table, then states, then labels, then the
  // bounds of times, then words.
  constexpr size_t kFirstState = 4;
  const auto parameter = [](size_t number) { return "?" + std::to_string(number); };
  const auto state_at = [&](size_t i) { return parameter(kFirstState + i); };
  const auto label_at = [&](size_t i) {
    const size_t name = kFirstState + filter.states.size() + 2 * i;
    return "name=" + parameter(name) + " AND value=" + parameter(name + 1);
  };
  std::string others;  // a + keeps a column's index out of it
  if (filter.table && !by_table) others += " AND (+jobs.table_in=?3 OR +jobs.table_out=?3)";
  if (!filter.states.empty() && !by_state) {
    others += " AND +jobs.state IN (";
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
  if (!times.empty() && !by_time)
    others += " AND EXISTS(SELECT 1 FROM jobs AS t INDEXED BY jobs_by_times WHERE t.id=jobs.id" +
              times + ")";
  const size_t first_word = first_time + (times.empty() ? 0 : std::size(bounds));
  for (size_t i = 0; i < filter.words.size(); ++i)
    others += std::string(" AND CASE WHEN json_valid(jobs.request) THEN instr(") + searched() +
              "," + parameter(first_word + 2 * i) + ") OR instr(" +
              parameter(first_word + 2 * i + 1) + "," + kScene + ") END";
  std::string ids;
  const auto add = [&](const std::string& from_where, const char* id = "id") {
    ids += (ids.empty() ? "" : " UNION ") +
           ("SELECT id FROM (SELECT jobs.id FROM " + from_where + " AND " + id + "<?1" + others +
            " ORDER BY " + id + " DESC LIMIT ?2)");
  };
  if (by_state) {
    for (size_t i = 0; i < filter.states.size(); ++i) add("jobs WHERE state=" + state_at(i));
  } else if (by_table) {
    for (const std::string column : {"table_in", "table_out"})
      add("jobs WHERE " + column + "=?3 AND " + column + "<>''");
  } else if (by_label) {
    add("job_labels CROSS JOIN jobs ON id=job WHERE " + label_at(0), "job");
  } else if (by_time) {
    add("jobs AS t INDEXED BY jobs_by_times CROSS JOIN jobs ON jobs.id=t.id WHERE 1" + times,
        "t.id");
  }
  const std::string sql = std::string("SELECT ") + kJobColumns + " FROM jobs WHERE id<?1 AND " +
                          (ids.empty() ? "1" + others : "id IN (" + ids + ")") +
                          " ORDER BY id DESC LIMIT ?2";
  Query query(reading.handle(), sql.c_str());
  query.bind(filter.before ? static_cast<int64_t>(filter.before->value) : INT64_MAX);
  query.bind(static_cast<int64_t>(limit));
  query.bind(filter.table);
  for (const JobState state : filter.states) query.bind(std::string(to_string(state)));
  for (const auto& [name, value] : filter.labels) query.bind(name).bind(value);
  if (!times.empty())
    for (const auto& [column, bound] : bounds) query.bind(bound);
  for (const auto& [text, scenes] : filter.words) query.bind(text).bind(scenes);
  std::vector<JobRecord> jobs;
  while (query.next()) jobs.push_back(read_job(query));
  if (Status s = query.status(); !s.ok()) return s.error();
  return jobs;
}

}  // namespace qray::server
