// A job of many frames: the same scene from several cameras, or as it moves, with one table that
// learns from all of them. They are rendered one after the other: where surfaces or lights move, in
// the order of time; else in one that spreads their views (spread_order()), so that the table soon
// knows what all frames see. Each begins with what it knows by then. A frame whose turn it is not
// is kept by the caller. Knows no paths, no HTTP.
#pragma once

#include "core/job/run_job.h"
#include "core/settings/frames.h"

namespace qray {

// What one of the frames has come to.
struct FrameProgress {
  uint64_t samples = 0, learning_samples = 0;  // a pixel
  double seconds = 0, noise = 0;               // of rendering it; 0: not known
  uint64_t paths = 0, rays = 0, dropped_samples = 0;
  template <class Self, class Archive>
  static void exchange(Self& self, Archive& archive) {
    archive(self.samples, self.learning_samples, self.seconds, self.noise, self.paths, self.rays,
            self.dropped_samples);
  }
};

// The caller's part; called by the thread that renders.
class FrameKeeper {
 public:
  virtual ~FrameKeeper() = default;
  // A frame's turn begins, with this film. The observer is told of it until the turn ends.
  virtual RenderObserver& begin_turn(int frame, std::shared_ptr<Film> film) = 0;
  // It has ended, and the frame is done: its picture and statistics. Its table is null.
  virtual Status end_turn(int frame, const FrameProgress& progress, const Film& film,
                          const JobResult& result) = 0;
  // Whether the frame is to be rendered: asked before its turn, and before each tile by worker
  // threads, one at a time, so that it must return at once.
  virtual bool wanted(int frame) {
    (void)frame;
    return true;
  }
  // It is not: it has no turn, or its turn has ended with what the film has of it (null: nothing).
  // Wanted again, it begins anew after the others.
  virtual Status left_out(int frame, const Film* film) {
    (void)frame, (void)film;
    return {};
  }
  // The state of a frame after one of its turns, beside that of the turn before.
  virtual Status save(int frame, int turn, const WriteState& write) = 0;
  // Gives it to `read`. kCorrupt: it is cut off, or `read` says no.
  virtual Status load(int frame, int turn, const std::function<bool(SnapshotReader&)>& read) = 0;
};

struct FramesJob {
  const JobRequest& request;       // its seeds
  const RenderSettings& settings;  // of each frame, but for camera and seed
  const std::vector<JobFrame>& frames;
  // The scene at a time (seconds): asked where its surfaces or lights move (Scene::moves_surfaces).
  using SceneAt = std::function<Result<std::shared_ptr<const PreparedScene>>(double)>;
  SceneAt scene_at{};
};

// As run_guided_job(); the statistics are of all frames, and there is no picture. Gone on with
// after its end, the job gives every frame what its settings have more than before.
Result<JobResult> run_frames(const PreparedScene& scene, const FramesJob& job, StartingGuide start,
                             FrameKeeper& frames, TaskPool& pool, std::stop_token stop,
                             const Clock& clock, const Recovery* recovery = nullptr,
                             const Checkpoints& checkpoints = {});

}  // namespace qray
