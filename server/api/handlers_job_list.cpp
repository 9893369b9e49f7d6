// Many jobs: the list, and the deletion of those that a filter finds.
#include <sstream>

#include "server/api/handlers_jobs.h"
#include "server/http/query.h"
#include "server/http/reply.h"

namespace qray::server {
namespace {

constexpr size_t kMostFilters = 16;  // of a kind

Error wrong(const char* expected, const char* pointer) {
  return {ErrorCode::kInvalid, expected, pointer};
}

Status read_times(const httplib::Request& req, JobStore::Filter& filter) {
  for (const auto& [name, time] : {std::pair{"created_from", &filter.created.from},
                                   std::pair{"created_before", &filter.created.before},
                                   std::pair{"ended_from", &filter.ended.from},
                                   std::pair{"ended_before", &filter.ended.before}}) {
    if (!req.has_param(name)) continue;
    *time = proto::parse_time(req.get_param_value(name));
    if (!*time)
      return Error{ErrorCode::kInvalid, "expected a time such as 2026-01-31T23:59:00Z",
                   std::string("/") + name};
  }
  return {};
}

std::string in_small_letters(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

// Each word of `q`, with the scenes whose titles contain it.
void read_words(const std::string& q, SceneStore& scenes, JobStore::Filter& filter) {
  std::vector<proto::SceneInfo> listed;
  std::istringstream words(in_small_letters(q));
  for (std::string word; words >> word; filter.words.push_back({word})) {
    if (listed.empty()) listed = scenes.list();
  }
  for (JobStore::Word& word : filter.words)
    for (const proto::SceneInfo& scene : listed)
      if (in_small_letters(scene.title).find(word.text) != std::string::npos)
        word.scenes += (word.scenes.empty() ? "," : "") + scene.name + ",";
}

Result<JobStore::Filter> read_filter(const httplib::Request& req, SceneStore& scenes) {
  JobStore::Filter filter;
  if (req.has_param("before")) {
    filter.before = JobId::parse(req.get_param_value("before"));
    if (!filter.before) return wrong("expected a job's id", "/before");
  }
  for (const std::string& name : query_values(req, "state")) {
    const std::optional<JobState> state = parse_job_state(name);
    if (!state) return wrong("expected a job's state", "/state");
    filter.states.push_back(*state);
  }
  if (req.has_param("table")) {
    filter.table = req.get_param_value("table");
    if (!proto::is_id(*filter.table)) return wrong("expected a table's id", "/table");
  }
  for (const std::string& label : query_values(req, "label")) {
    const size_t colon = label.find(':');
    const std::string name = label.substr(0, colon);
    if (colon == std::string::npos || !proto::is_name(name))
      return wrong("expected name:value", "/label");
    filter.labels.emplace_back(name, label.substr(colon + 1));
  }
  if (filter.states.size() > kMostFilters || filter.labels.size() > kMostFilters)
    return wrong("expected at most 16 states and 16 labels",
                 filter.labels.size() > kMostFilters ? "/label" : "/state");
  if (Status s = read_times(req, filter); !s.ok()) return s.error();
  read_words(req.get_param_value("q"), scenes, filter);
  if (filter.words.size() > kMostFilters) return wrong("expected at most 16 words", "/q");
  return filter;
}

}  // namespace

void JobHandlers::list(const Request& req, Response& res) {
  const Result<int> limit = query_number(req, "limit", 1, 200, 50);
  if (!limit.ok()) return reply_error(res, limit.error());
  const Result<JobStore::Filter> filter = read_filter(req, stores_.scenes);
  if (!filter.ok()) return reply_error(res, filter.error());
  const size_t wanted = static_cast<size_t>(limit.value());
  Result<std::vector<JobRecord>> jobs = stores_.jobs.list(wanted + 1, filter.value());
  if (!jobs.ok()) return reply_error(res, jobs.error());
  std::vector<proto::JobInfo> infos;
  for (const JobRecord& job : jobs.value()) {
    if (infos.size() < wanted) infos.push_back(info(job));
  }
  const std::string next = jobs.value().size() > wanted ? infos.back().id : "";
  reply_tagged(req, res, proto::job_list_to_json(infos, next));
}

// Those that have ended, the newest first. All at once would hold up the others' writes.
void JobHandlers::remove_many(const Request& req, Response& res) {
  const Result<int> limit = query_number(req, "limit", 1, 200, 200);
  if (!limit.ok()) return reply_error(res, limit.error());
  Result<JobStore::Filter> filter = read_filter(req, stores_.scenes);
  if (!filter.ok()) return reply_error(res, filter.error());
  std::vector<JobState>& states = filter.value().states;
  for (const JobState state : states)
    if (!has_ended(state))
      return reply_error(res, wrong("expected a state of jobs that have ended", "/state"));
  if (req.params.empty() || (req.params.size() == 1 && req.has_param("limit")))
    return reply_problem(
        res, {422, "Wrong request", "expected a filter: which jobs, of those that have ended", {}});
  if (states.empty()) states = {JobState::kSucceeded, JobState::kCanceled, JobState::kFailed};
  const size_t wanted = static_cast<size_t>(limit.value());
  const Result<std::vector<JobRecord>> jobs = stores_.jobs.list(wanted + 1, filter.value());
  if (!jobs.ok()) return reply_error(res, jobs.error());
  std::vector<std::string> deleted;
  for (const JobRecord& job : jobs.value()) {
    if (deleted.size() == wanted) break;
    const Status removed = runner_.remove(job.id);
    if (removed.ok()) {
      deleted.push_back(job.id.text());
    } else if (removed.error().code == ErrorCode::kIo) {
      return reply_error(res, removed.error());
    }  // else it was extended, or somebody else has deleted it
  }
  reply_json(res, 200, proto::deleted_to_json(deleted, jobs.value().size() > wanted));
}

}  // namespace qray::server
