#include "server/jobs/progress_ticker.h"

#include <spdlog/spdlog.h>

#include "proto/events.h"
#include "server/jobs/wait.h"

namespace qray::server {
namespace {

using std::chrono::milliseconds;
constexpr milliseconds kLook{50};            // for the end of learning
constexpr milliseconds kBetweenEvents{500};  // progress events

}  // namespace

ProgressTicker::ProgressTicker(JobStore& jobs, const RunningJob& job, uint64_t claim,
                               const Lease& lease, bool learning, bool frames)
    : thread_([this, &jobs, &job, claim, &lease, learning, frames](std::stop_token stop) {
        try {
          watch(stop, jobs, job, claim, lease, learning, frames);
        } catch (const std::exception& e) {
          spdlog::error("job={} no more progress: {}", job.id().text(), e.what());
        }
      }) {}

void ProgressTicker::watch(std::stop_token stop, JobStore& jobs, const RunningJob& job,
                           uint64_t claim, const Lease& lease, bool learning, bool frames) {
  auto last = std::chrono::steady_clock::now() - kBetweenEvents;
  std::pair<uint64_t, uint64_t> last_version{1, 0};  // nothing of the first film
  while (wait_unless(stop, kLook)) {
    if (learning && job.past_learning()) {
      learning = false;
      JobStore::Change change;
      change.claim = claim;
      const Result<JobRecord> moved = jobs.move(job.id(), JobState::kRendering, change);
      if (!moved.ok() && moved.error().code != ErrorCode::kConflict) {  // conflict: canceled
        spdlog::error("job={} {}", job.id().text(), moved.error().text());
      }
    }
    const RunningJob::Shown shown = job.shown();
    if (!shown.film) continue;
    const std::pair version{shown.films, shown.film->version()};
    const auto now = std::chrono::steady_clock::now();
    if (version == last_version || now - last < kBetweenEvents || !lease.holds()) continue;
    last = now;
    last_version = version;
    const std::string name = job.id().text();
    jobs.publish_hint({0, name, "progress",
                       proto::progress_event(name, job.progress(), version.second,
                                             frames ? std::optional(shown.frame) : std::nullopt)});
  }
}

}  // namespace qray::server
