#include "server/api/handlers_health.h"

#include <spdlog/spdlog.h>

#include "core/base/build_commit.h"
#include "proto/json_text.h"
#include "server/http/reply.h"

namespace qray::server {
namespace {

// Anyone may ask, and each look is a write to the disk.
constexpr std::chrono::milliseconds kLookAtFaults{1000};

std::string version_json(int64_t started_ms) {
  const proto::JsonField fields[] = {
      {"name", std::string("qray")},           {"version", std::string(QRAY_VERSION)},
      {"api_version", std::string("1")},       {"build_type", std::string(QRAY_BUILD_TYPE)},
      {"commit", std::string(build_commit())}, {"started", proto::time_to_text(started_ms)},
  };
  return proto::json_object(fields, /*indent=*/false);
}

}  // namespace

void HealthHandlers::add_to(Router& router) {
  router.add("GET", "/v1/", [json = version_json(started_ms_)](auto&, auto& res, auto&) {
    reply_json(res, 200, json);
  });
  router.add(
      "GET", "/healthz",
      [](auto&, auto& res, auto&) { reply_json(res, 200, proto::health_to_json()); }, Scope::kOpen);
  router.add(
      "GET", "/readyz", [this](auto&, auto& res, auto&) { ready(res); }, Scope::kOpen);
  router.add("GET", "/metrics", [this](auto&, auto& res, auto&) { metrics(res); });
  router.add("GET", "/openapi.json",
             [this](auto&, auto& res, auto&) { reply_json(res, 200, uses_.openapi_json); });
}

std::string HealthHandlers::why_not_ready() {
  if (draining_) return "the server stops";
  std::lock_guard lock(mutex_);
  const auto now = std::chrono::steady_clock::now();  // the time of day may be set back
  if (looked_ && now - *looked_ < kLookAtFaults) return fault_;
  looked_ = now;
  fault_.clear();
  std::error_code ec;
  const auto space = std::filesystem::space(uses_.data, ec);
  if (ec || space.available < uses_.min_free_bytes) {
    fault_ = "expected " + std::to_string(uses_.min_free_bytes >> 20) +
             " MiB free for the data folder, got " +
             (ec ? "no answer" : std::to_string(space.available >> 20));
  } else if (Status s = uses_.jobs.try_writing(); !s.ok()) {
    spdlog::error("not ready: {}", s.error().text());
    fault_ = "the database cannot be written";
  }
  return fault_;
}

void HealthHandlers::ready(httplib::Response& res) {
  const std::string fault = why_not_ready();
  if (!fault.empty()) return reply_problem(res, {503, "Not ready", fault, {}});
  reply_json(res, 200, R"({"status":"ready"})");
}

Status HealthHandlers::count_workers(MetricsNow& now) const {
  if (!uses_.shared) return {};
  const Result<std::vector<WorkerInfo>> workers = uses_.shared->workers();
  if (!workers.ok()) return workers.error();
  now.farm = true;
  for (const char* state : {"busy", "idle", "draining", "silent"}) now.workers[state] = 0;
  const double lease = std::chrono::duration<double>(uses_.shared->lease()).count();
  for (const WorkerInfo& worker : workers.value()) {
    if (worker.threads == 0) continue;
    const bool silent = worker.silent_seconds > lease;
    ++now.workers[silent                ? "silent"
                  : worker.draining     ? "draining"
                  : worker.jobs.empty() ? "idle"
                                        : "busy"];
    if (!silent) now.farm_samples_a_second += worker.samples_a_second;
  }
  return {};
}

void HealthHandlers::metrics(httplib::Response& res) {
  MetricsNow now;
  const Result<JobStore::Counts> counts = uses_.jobs.count();
  if (!counts.ok()) return reply_error(res, counts.error());
  // A state that no job is in any more says 0.
  for (const std::string_view state : kJobStateNames) now.jobs[std::string(state)] = 0;
  for (const auto& [state, count] : counts.value().by_state)
    now.jobs[std::string(to_string(state))] = static_cast<int64_t>(count);
  if (counts.value().oldest_queued_ms) {
    now.queue_age_seconds =
        static_cast<double>(uses_.now_ms() - *counts.value().oldest_queued_ms) / 1000;
  }
  if (Status s = count_workers(now); !s.ok()) return reply_error(res, s.error());
  now.streams = uses_.events.stream_count();
  now.connections = uses_.connections();
  now.live_sessions = uses_.live_sessions();
  res.status = 200;
  res.set_header("Cache-Control", "no-store");
  res.set_content(uses_.metrics.text(now), "text/plain; version=0.0.4; charset=utf-8");
}

}  // namespace qray::server
