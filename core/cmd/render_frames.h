// qray render, of many frames: pictures in a folder, or one file that plays. One thread.
#pragma once

#include <filesystem>

#include "core/base/temporary_folder.h"
#include "core/cmd/progress_line.h"
#include "core/image/image.h"
#include "core/job/run_frames.h"

namespace qray::cmd {

// Frames that wait for their turn, as files in a folder of the system's for such things that goes
// when this does; their pictures as they are so far, and the newest statistics.
class FrameFiles final : public FrameKeeper {
 public:
  using WritePicture = std::function<Status(int frame, Image image, const ImageMetadata& metadata,
                                            const std::optional<LayeredPicture>& passes)>;
  FrameFiles(int count, ProgressLine& line, WritePicture write);

  RenderObserver& begin_turn(int frame, std::shared_ptr<Film> film) override;
  Status end_turn(int frame, const FrameProgress& progress, const Film& film,
                  const JobResult& result) override;
  Status save(int frame, int turn, const WriteState& write) override;
  Status load(int frame, int turn, const std::function<bool(SnapshotReader&)>& read) override;

  const std::vector<RenderStats>& stats() const { return stats_; }  // by frame

 private:
  class Progress final : public RenderObserver {
   public:
    Progress(ProgressLine& line, size_t count) : line_(line), fractions_(count) {}
    void begin(int frame) { frame_ = static_cast<size_t>(frame); }
    void done() { fractions_[frame_] = 1; }
    void on_tile(const RenderProgress& progress) override;
    void on_pass(const RenderProgress& progress, const RenderStats&, const Guide*) override {
      on_tile(progress);
    }

   private:
    ProgressLine& line_;
    const SteadyClock clock_;
    const double start_ = clock_.seconds();
    std::vector<double> fractions_;
    size_t frame_ = 0;
  };
  std::filesystem::path file(int frame, int turn) const;

  TemporaryFolder folder_;
  Progress progress_;
  const WritePicture write_;
  std::vector<RenderStats> stats_;
};

// Where frames go: pictures in a folder, named "frame-0000.png", or an animation.
struct FramesOut {
  std::filesystem::path path;
  std::string format = "png";  // of pictures
  double per_second = 12;      // of an animation

  bool plays() const;
  std::filesystem::path picture(int frame) const;
};
// Makes the folder. kInvalid, kIo, kUnsupported: nothing can be written there.
Status prepare_output(const FramesOut& out);

}  // namespace qray::cmd
