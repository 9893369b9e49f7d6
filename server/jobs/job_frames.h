// The frames of a running job: their states and pictures on disk, and what is told of them. The
// thread that renders.
#pragma once

#include <mutex>
#include <vector>

#include "core/job/run_frames.h"
#include "server/jobs/lease.h"
#include "server/jobs/running_job.h"
#include "server/store/checkpoint_store.h"
#include "server/store/job_store.h"
#include "server/store/result_store.h"

namespace qray::server {

class JobFrames final : public FrameKeeper {
 public:
  struct Uses {
    CheckpointStore& checkpoints;
    ResultStore& results;
    JobStore& jobs;  // hints
    RunningJob& running;
    const Lease& lease;  // where it does not hold, nothing is written
  };
  // All outlive this. `goes_on`: what is kept of the frames counts. `stop`: a state that is being
  // written then is given up.
  JobFrames(const Uses& uses, JobId id, const std::vector<JobFrame>& frames, bool goes_on,
            std::stop_token stop);

  RenderObserver& begin_turn(int frame, std::shared_ptr<Film> film) override;
  Status end_turn(int frame, const FrameProgress& progress, const Film& film,
                  const JobResult& result) override;
  bool wanted(int frame) override;
  Status left_out(int frame, const Film* film) override;
  Status save(int frame, int turn, const WriteState& write) override;
  Status load(int frame, int turn, const std::function<bool(SnapshotReader&)>& read) override;

  const std::optional<RenderStats>& last() const { return last_; }  // of the last turn

 private:
  proto::FrameInfo& info(int frame) { return infos_[static_cast<size_t>(frame)]; }
  void take_up();
  Status keep();

  const Uses uses_;
  const JobId id_;
  const std::stop_token stop_;
  std::vector<proto::FrameInfo> infos_;
  std::optional<RenderStats> last_;
  // As they were last read.
  std::set<int> canceled_;
  std::filesystem::file_time_type canceled_at_;
};

}  // namespace qray::server
