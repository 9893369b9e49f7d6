#include "server/jobs/job_keeper.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

namespace qray::server {
namespace {

constexpr double kFirstSeconds = 1;
constexpr double kShare = 0.05;             // of the time, that may go into writing
constexpr double kMostSecondsBetween = 10;  // between two, while that share is
constexpr double kCostlySeconds = 1;        // a state that takes longer to write
constexpr double kCostlyShare = 0.1;        // may take this share,
constexpr double kMostCostly = 30;          // up to so many seconds between two

double period(double cost) {
  if (cost < kCostlySeconds) return std::clamp(cost / kShare, kFirstSeconds, kMostSecondsBetween);
  return std::min(cost / kCostlyShare, kMostCostly);
}

}  // namespace

void JobKeeper::start(CheckpointHeader header) {
  header_ = std::move(header);
  next_.store(clock_.seconds() + kFirstSeconds, std::memory_order_relaxed);
}

bool JobKeeper::due() {
  return held_.load(std::memory_order_relaxed) ||
         clock_.seconds() >= next_.load(std::memory_order_relaxed);
}

bool JobKeeper::save(const std::function<void(SnapshotWriter&)>& write) {
  const double start = clock_.seconds();
  const Status written = store_.save(id_, header_, write,
                                     [this] { return stop_.stop_requested() || !lease_.holds(); });
  const double end = clock_.seconds();
  next_.store(end + period(end - start), std::memory_order_relaxed);
  if (written.ok()) {
    if (on_first_save_) std::exchange(on_first_save_, nullptr)();
    failure_.clear();
  } else if (written.error().code != ErrorCode::kCanceled) {
    if (failure_.empty())
      spdlog::warn("job={} its state cannot be written: {}", id_.text(), written.error().text());
    failure_ = written.error().text();
  }
  return !held_.load(std::memory_order_relaxed);
}

}  // namespace qray::server
