// Decides when a running job writes its state: as often as costs little, and at least every ten
// seconds while that takes less than a second. Also how a job is held: it writes its state, and its
// render ends. due() and hold() from any thread, the rest from the job's.
#pragma once

#include <atomic>
#include <stop_token>

#include "core/base/clock.h"
#include "core/render/checkpoint.h"
#include "server/jobs/lease.h"
#include "server/store/checkpoint_store.h"

namespace qray::server {

class JobKeeper final : public Checkpointer {
 public:
  // A state that is being written when `stop` is asked for is given up.
  // `lease` outlives it: where it does not hold, nothing is written.
  JobKeeper(CheckpointStore& store, JobId id, const Clock& clock, std::stop_token stop,
            const Lease& lease)
      : store_(store), id_(id), clock_(clock), stop_(std::move(stop)), lease_(lease) {}

  // What is written with the states from now on; the first is due soon after.
  void start(CheckpointHeader header);
  // The render shall end at its next tile.
  void hold() { held_.store(true, std::memory_order_relaxed); }
  // Why the last attempt to write failed; empty when it did not.
  const std::string& failure() const { return failure_; }
  // Called once, after the first state that was written.
  void on_first_save(std::function<void()> call) { on_first_save_ = std::move(call); }

  bool due() override;
  bool save(const std::function<void(SnapshotWriter&)>& write) override;

 private:
  CheckpointStore& store_;
  const JobId id_;
  const Clock& clock_;
  const std::stop_token stop_;
  const Lease& lease_;
  CheckpointHeader header_;
  std::function<void()> on_first_save_;
  std::atomic<bool> held_ = false;
  std::atomic<double> next_ = 0;  // seconds of clock_
  std::string failure_;
};

}  // namespace qray::server
