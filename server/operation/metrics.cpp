#include "server/operation/metrics.h"

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>
#include <unistd.h>

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <fstream>

#include "proto/json_text.h"

namespace qray::server {
namespace {

using prometheus::Counter;
using prometheus::Family;
using prometheus::Gauge;

double resident_bytes() {
  double total = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> total >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE));
}

double open_files() {
  std::error_code ec;
  double count = -1;  // the one that looks
  for (std::filesystem::directory_iterator it("/proc/self/fd", ec), end; !ec && it != end;
       it.increment(ec))
    ++count;
  return count;
}

}  // namespace

struct Metrics::Impl {
  prometheus::Registry registry;

  Family<Counter>& counters(const char* name, const char* help) {
    return prometheus::BuildCounter().Name(name).Help(help).Register(registry);
  }
  Family<Gauge>& gauges(const char* name, const char* help) {
    return prometheus::BuildGauge().Name(name).Help(help).Register(registry);
  }

  Family<Counter>& requests = counters("qray_http_requests_total", "Requests that were answered");
  Family<Counter>& request_seconds =
      counters("qray_http_request_seconds_total", "Time from head to answer, streams too");
  Counter& bytes_in = counters("qray_http_received_bytes_total", "Of ended requests").Add({});
  Counter& bytes_out = counters("qray_http_sent_bytes_total", "Of ended requests").Add({});
  Counter& failures = counters("qray_http_errors_total", "Answers of status 500 and up").Add({});
  Family<Counter>& rays = counters("qray_rays_total", "Rays of ended jobs, by phase");
  Family<Counter>& phases = counters("qray_job_seconds_total", "Time of ended jobs, by phase");
  Family<Counter>& ends = counters("qray_jobs_ended_total", "Jobs that ended, by how");
  Family<Counter>& starts = counters("qray_table_starts_total",
                                     "Learning jobs that found a table (warm), or none (cold)");
  Counter& frames = counters("qray_live_frames_total", "Frames of live sessions").Add({});
  Counter& live_rays = counters("qray_live_rays_total", "Rays of live sessions").Add({});
  Family<Counter>& live_phases =
      counters("qray_live_seconds_total", "Time of live sessions' frames, by phase");
  Family<Gauge>& jobs = gauges("qray_jobs", "Jobs on disk, by state");
  Gauge& queue_age = gauges("qray_queue_age_seconds", "Age of the oldest queued job").Add({});
  Gauge& streams = gauges("qray_event_streams", "Open event streams").Add({});
  Gauge& connections = gauges("qray_connections", "Open connections").Add({});
  Gauge& live_sessions = gauges("qray_live_sessions", "Open live sessions").Add({});
  Family<Gauge>& workers = gauges("qray_farm_workers", "Processes that run jobs, by state");
  Family<Gauge>& farm_samples =
      gauges("qray_farm_samples_per_second", "Of all processes of the farm");
  Gauge& resident = gauges("process_resident_memory_bytes", "Memory in use").Add({});
  Gauge& files = gauges("process_open_fds", "Open file descriptors").Add({});
  Gauge& started =
      gauges("process_start_time_seconds", "When this server started, since 1970").Add({});
};

Metrics::Metrics() : impl_(std::make_unique<Impl>()) {
  impl_->started.Set(static_cast<double>(std::time(nullptr)));
}

Metrics::~Metrics() = default;

void Metrics::add_exchange(const Exchange& exchange) {
  const std::string route = exchange.route.empty() ? "none" : exchange.route;
  const std::string method = exchange.method.empty() ? "none" : exchange.method;
  impl_->requests
      .Add({{"method", method}, {"route", route}, {"status", std::to_string(exchange.status)}})
      .Increment();
  impl_->request_seconds.Add({{"method", method}, {"route", route}}).Increment(exchange.seconds);
  impl_->bytes_in.Increment(static_cast<double>(exchange.bytes_in));
  impl_->bytes_out.Increment(static_cast<double>(exchange.bytes_out));
  if (exchange.status >= 500) impl_->failures.Increment();
}

// Rays and time are measured as a whole, and learning is a share of the samples, so that it gets
// the same share of both.
void Metrics::add_job(const RenderStats& stats, const std::string& before,
                      double finalizing_seconds, bool warm) {
  const auto since = [&](const char* name, auto now) {
    return std::max(0.0, static_cast<double>(now) - proto::json_number(before, name));
  };
  const double samples = since("samples", stats.samples_per_pixel);
  const double learning =
      samples > 0
          ? std::min(1.0, since("learning_samples", stats.learning_samples_per_pixel) / samples)
          : 0;
  const auto add = [&](const char* phase, double seconds, double rays) {
    impl_->phases.Add({{"phase", phase}}).Increment(seconds);
    if (rays > 0) impl_->rays.Add({{"phase", phase}}).Increment(rays);
  };
  const double rays = since("rays", stats.rays), seconds = since("seconds", stats.seconds);
  add("prepare", stats.prepare_seconds, 0);
  add("learning", seconds * learning, rays * learning);
  add("rendering", seconds * (1 - learning), rays * (1 - learning));
  add("recovery", stats.recovery_seconds, 0);
  add("finalizing", finalizing_seconds, 0);
  if (stats.method != "none" && before.empty())
    impl_->starts.Add({{"kind", warm ? "warm" : "cold"}}).Increment();
}

void Metrics::add_end(std::string_view state) {
  impl_->ends.Add({{"state", std::string(state)}}).Increment();
}

void Metrics::add_frame(const LiveFrame& frame) {
  const LiveTimes& t = frame.times;
  impl_->frames.Increment();
  impl_->live_rays.Increment(static_cast<double>(frame.rays));
  for (const auto& [phase, seconds] :
       {std::pair{"features", t.features}, std::pair{"reprojection", t.reprojection},
        std::pair{"samples", t.samples}, std::pair{"learning", t.learning},
        std::pair{"recovery", t.recovery}})
    impl_->live_phases.Add({{"phase", phase}}).Increment(seconds);
}

std::string Metrics::text(const MetricsNow& now) {
  for (const auto& [state, count] : now.jobs)
    impl_->jobs.Add({{"state", state}}).Set(static_cast<double>(count));
  impl_->queue_age.Set(now.queue_age_seconds);
  impl_->streams.Set(static_cast<double>(now.streams));
  impl_->live_sessions.Set(static_cast<double>(now.live_sessions));
  for (const auto& [state, count] : now.workers)
    impl_->workers.Add({{"state", state}}).Set(static_cast<double>(count));
  if (now.farm) impl_->farm_samples.Add({}).Set(now.farm_samples_a_second);
  impl_->connections.Set(static_cast<double>(now.connections));
  impl_->resident.Set(resident_bytes());
  impl_->files.Set(open_files());
  return prometheus::TextSerializer().Serialize(impl_->registry.Collect());
}

}  // namespace qray::server
