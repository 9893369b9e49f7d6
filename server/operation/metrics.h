// The counters behind GET /metrics, and their Prometheus text form. Labels are routes, methods,
// statuses and states: never what a client wrote. Any thread.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "core/live/live_view.h"
#include "core/render/stats.h"
#include "server/http/http_server.h"

namespace qray::server {

// What is true at the moment of asking.
struct MetricsNow {
  std::map<std::string, int64_t> jobs;  // by state
  double queue_age_seconds = 0;         // of the job that waits longest
  size_t streams = 0, connections = 0, live_sessions = 0;
  bool farm = false;                         // then there are
  std::map<std::string, int64_t> workers{};  // by state: busy, idle, draining, silent
  double farm_samples_a_second = 0;
};

class Metrics {
 public:
  Metrics();
  ~Metrics();

  void add_exchange(const Exchange& exchange);
  // What a job that has ended did up to its last pass, without what was added when it ended
  // `before` it was extended: the JSON of its statistics then, or empty. `warm`: it started from a
  // table.
  void add_job(const RenderStats& stats, const std::string& before, double finalizing_seconds,
               bool warm);
  void add_end(std::string_view state);  // of a job
  void add_frame(const LiveFrame& frame);
  std::string text(const MetricsNow& now);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace qray::server
