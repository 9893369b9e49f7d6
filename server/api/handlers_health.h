// The server seen from outside: GET /v1/, /healthz, /readyz, /metrics and /openapi.json. Any
// thread.
#pragma once

#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>

#include "server/api/handlers_events.h"
#include "server/operation/metrics.h"
#include "server/store/job_store.h"
#include "server/store/shared_jobs.h"

namespace qray::server {

class HealthHandlers {
 public:
  struct Uses {
    JobStore& jobs;
    Metrics& metrics;
    const EventHandlers& events;
    std::function<size_t()> connections, live_sessions;
    std::function<int64_t()> now_ms;
    std::filesystem::path data;
    uint64_t min_free_bytes;
    std::string openapi_json;
    SharedJobs* shared = nullptr;  // of a farm
  };
  explicit HealthHandlers(Uses uses) : uses_(std::move(uses)), started_ms_(uses_.now_ms()) {}
  void add_to(Router& router);
  // From now on the server is not ready: it stops.
  void drain() { draining_ = true; }

 private:
  void ready(httplib::Response& res);
  void metrics(httplib::Response& res);
  Status count_workers(MetricsNow& now) const;
  std::string why_not_ready();  // empty: it is

  const Uses uses_;
  const int64_t started_ms_;
  std::atomic<bool> draining_{false};
  std::mutex mutex_;  // guards the last look, which is good for a moment
  std::optional<std::chrono::steady_clock::time_point> looked_;
  std::string fault_;
};

}  // namespace qray::server
