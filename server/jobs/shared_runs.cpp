// How jobs are run that several processes share: what this one claims, and how it stays its own.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>

#include "core/base/build_identity.h"
#include "server/jobs/bits_of_machine.h"
#include "server/jobs/job_run.h"
#include "server/jobs/wait.h"
#include "server/operation/metrics.h"

namespace qray::server {
namespace {

using std::chrono::milliseconds;
constexpr milliseconds kLookForRuns{1000};
constexpr milliseconds kMostBetweenRenewals{2000};

}  // namespace

void JobRunner::work_shared(std::stop_token stop) {
  bool told = false;
  while (!stop.stop_requested()) {
    try {
      if (const std::optional<JobRecord> job = claim_shared(stop)) {
        run_shared(*job, stop);
        continue;
      }
      told = false;
    } catch (const std::exception& e) {
      if (!std::exchange(told, true)) spdlog::error("no jobs are claimed: {}", e.what());
    }
    stores_.shared->wait_for_news(stop, kLookForRuns);
  }
}

// Only who holds claim_mutex_ makes a job run, so what it sees of the others stays so.
std::optional<JobRecord> JobRunner::claim_shared(std::stop_token stop) {
  std::lock_guard claiming(claim_mutex_);
  bool is_free = false;
  {
    std::unique_lock lock(mutex_);
    ended_.wait(lock, stop, [&] { return !alone_; });
    if (stop.stop_requested() || draining_) return {};
    is_free = running_.empty();
  }
  const int64_t before = Lease::now_ms();
  Result<std::optional<JobRecord>> claimed = stores_.shared->claim(/*suspects_too=*/is_free);
  if (!claimed.ok()) throw std::runtime_error(claimed.error().text());
  if (!claimed.value()) return {};
  JobRecord& job = *claimed.value();
  std::unique_lock lock(mutex_);
  // This process may have run it before, and lost it.
  ended_.wait(lock, stop, [&] { return !running_.contains(job.id); });
  Running running = new_run(job.id);
  running.claim = job.claim;
  running.lease->extend_to(before + stores_.shared->lease().count());
  if (stop.stop_requested()) running.cancel.request_stop();
  if (job.attempts >= kMaxAttempts) alone_ = job.id;
  running_.insert_or_assign(job.id, std::move(running));
  return std::move(job);
}

void JobRunner::run_shared(const JobRecord& record, std::stop_token stop) {
  const JobId id = record.id;
  TaskPool share(pool_, std::exp2(record.request.get(field::kPriority)));
  Running running;
  {
    std::lock_guard lock(mutex_);
    running = running_.at(id);
  }
  JobRun job(context_of(id, running, share, std::move(stop)), id);
  job.claimed(record);
  carry_out(job, id);
}

void JobRunner::help_others() {
  const auto is_free = [this] {
    std::lock_guard lock(mutex_);
    return running_.empty() && !draining_;
  };
  helper_.emplace(PassHelper::Uses{*stores_.passes, stores_.jobs, stores_.scenes, stores_.tables,
                                   pool_, memory_, clock_, is_free});
  workers_.emplace_back([this](std::stop_token stop) { helper_->run(stop); });
}

void JobRunner::keep_leases(std::stop_token stop) {
  const milliseconds lease = stores_.shared->lease();
  const milliseconds between = std::clamp(lease / 5, milliseconds(20), kMostBetweenRenewals);
  // Where the database was away, the others get as long to come back as they had before.
  int64_t in_touch_since = Lease::now_ms();
  bool told = false;
  while (!stop.stop_requested()) {
    const bool renewed = renew_leases() && be_present();
    if (!renewed) {
      if (!std::exchange(told, true)) spdlog::error("leases cannot be renewed");
      in_touch_since = Lease::now_ms();
    } else {
      if (std::exchange(told, false)) spdlog::info("leases are renewed again");
      if (Lease::now_ms() - in_touch_since >= lease.count()) take_up_lost();
    }
    stores_.shared->wait_for_news(stop, between);
  }
}

void JobRunner::take_up_lost() {
  const Result<std::vector<JobId>> lost = stores_.shared->take_up_lost();
  if (!lost.ok()) return spdlog::error("jobs that were lost: {}", lost.error().text());
  for (const JobId id : lost.value()) stores_.results.remove_half_written(id);
}

bool JobRunner::renew_leases() {
  std::vector<SharedJobs::Run> runs;
  std::map<JobId, uint64_t> samples;
  {
    std::lock_guard lock(mutex_);
    for (const auto& [id, running] : running_) {
      runs.push_back({id, running.claim, {}});
      if (!running.shown) continue;
      runs.back().progress = running.shown->progress();
      const std::shared_ptr<const Film> film = running.shown->shown().film;
      if (film)
        samples[id] = runs.back().progress.samples * static_cast<uint64_t>(film->width()) *
                      static_cast<uint64_t>(film->height());
    }
  }
  speed_.look(std::move(samples), helper_ ? helper_->samples() : 0, clock_.seconds());
  if (runs.empty()) return true;
  const int64_t before = Lease::now_ms();
  const Result<std::vector<SharedJobs::Held>> held = stores_.shared->renew(runs);
  if (!held.ok()) return false;
  std::lock_guard lock(mutex_);
  for (const SharedJobs::Run& run : runs) {
    const auto found = running_.find(run.id);
    if (found == running_.end() || found->second.claim != run.claim) continue;
    Running& running = found->second;
    const auto mine = std::find_if(held.value().begin(), held.value().end(),
                                   [&](const SharedJobs::Held& h) { return h.id == run.id; });
    if (mine == held.value().end()) {
      spdlog::info("job={} is not this process's any more", run.id.text());
      running.lease->lose();
      running.cancel.request_stop();
      continue;
    }
    running.lease->extend_to(before + stores_.shared->lease().count());
    if (mine->state == JobState::kCanceling) running.cancel.request_stop();
    if (mine->state == JobState::kPausing) {
      running.keeper->hold();
      if (!running.shown) running.cancel.request_stop();  // while its scene is loaded
    }
  }
  return true;
}

bool JobRunner::be_present() {
  WorkerInfo me;
  me.kind = limits_.kind;
  me.build = std::string(build_identity()).substr(0, 12);
  me.bits = bits_of_machine();
  if (helper_) me.helps = helper_->helps();
  me.threads = limits_.at_once > 0 ? limits_.threads : 0;
  me.samples = speed_.samples();
  me.samples_a_second = speed_.a_second();
  const Result<bool> wanted = stores_.shared->present(me);
  if (!wanted.ok()) return false;
  if (!wanted.value()) drain();
  return true;
}

void JobRunner::drain() {
  std::lock_guard lock(mutex_);
  if (!std::exchange(draining_, true)) spdlog::info("draining: no more jobs are taken");
}

bool JobRunner::is_drained() const {
  std::lock_guard lock(mutex_);
  return draining_ && running_.empty() && !(helper_ && helper_->helps());
}

}  // namespace qray::server
