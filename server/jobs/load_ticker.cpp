#include "server/jobs/load_ticker.h"

#include "proto/events.h"

namespace qray::server {
namespace {

constexpr double kBetweenSeconds = 0.5;

}  // namespace

bool LoadTicker::tell(LoadStep step, double fraction) {
  if (stop_.stop_requested()) return false;
  const double now = clock_.seconds();
  {
    std::lock_guard lock(mutex_);
    if (now - last_ < kBetweenSeconds) return true;
    last_ = now;
  }
  const std::string name = id_.text();
  const std::string_view step_name = step == LoadStep::kReading ? "reading" : "building";
  jobs_.publish_hint(
      {0, name, "loading", proto::loading_event(name, step_name, fraction, now - start_)});
  return true;
}

}  // namespace qray::server
