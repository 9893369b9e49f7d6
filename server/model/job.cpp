#include "server/model/job.h"

#include <algorithm>
#include <charconv>
#include <cstdio>

namespace qray::server {

std::optional<JobState> parse_job_state(std::string_view name) {
  const auto* end = std::end(kJobStateNames);
  const auto* found = std::find(std::begin(kJobStateNames), end, name);
  if (found == end) return std::nullopt;
  return static_cast<JobState>(found - std::begin(kJobStateNames));
}

std::string JobId::text() const {
  char text[32];
  std::snprintf(text, sizeof text, "j%06llu", static_cast<unsigned long long>(value));
  return text;
}

std::optional<JobId> JobId::parse(std::string_view text) {
  if (text.size() < 7 || text.size() > 19 || text.front() != 'j') return std::nullopt;
  JobId id;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data() + 1, end, id.value);
  if (error != std::errc{} || stop != end || id.text() != text) return std::nullopt;
  return id;
}

proto::JobInfo JobRecord::info() const {
  return {id.text(),  std::string(to_string(state)),
          request,    created_ms,
          started_ms, ended_ms,
          progress,   error,
          table_in,   table_out,
          stats_json, biased,
          warnings};
}

}  // namespace qray::server
