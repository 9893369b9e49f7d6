#include "server/jobs/janitor.h"

#include <spdlog/spdlog.h>

#include "server/jobs/wait.h"

namespace qray::server {
namespace {

constexpr std::chrono::minutes kBetweenRounds{10};
constexpr size_t kAtOnce = 100;
constexpr double kDayMs = 24 * 3600 * 1000.0;

}  // namespace

size_t Janitor::sweep(JobRunner& runner, const JobStore& jobs, double keep_days, int64_t now_ms) {
  size_t removed = 0;
  const int64_t before = now_ms - static_cast<int64_t>(keep_days * kDayMs);
  for (bool more = true; more;) {
    const Result<std::vector<JobId>> due = jobs.ended_before(before, kAtOnce);
    if (!due.ok()) break;
    more = false;
    for (JobId id : due.value()) {
      if (!runner.remove(id).ok()) continue;  // it goes on, or the disk does not
      ++removed;
      more = true;
    }
  }
  if (removed > 0) spdlog::info("deleted {} jobs that ended {} days ago", removed, keep_days);
  return removed;
}

Janitor::Janitor(JobRunner& runner, const JobStore& jobs, double keep_days,
                 std::function<int64_t()> now_ms) {
  if (keep_days <= 0) return;
  thread_ = std::jthread([&runner, &jobs, keep_days, now_ms](std::stop_token stop) {
    do {
      sweep(runner, jobs, keep_days, now_ms());
    } while (wait_unless(stop, kBetweenRounds));
  });
}

}  // namespace qray::server
