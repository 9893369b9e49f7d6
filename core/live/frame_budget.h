// How many paths, and how many pixels, fit a frame of a given time: by what the last ones took.
// One thread.
#pragma once

#include <algorithm>

namespace qray {

class FrameBudget {
 public:
  explicit FrameBudget(double seconds) : seconds_(seconds) {}

  double seconds() const { return seconds_; }
  // Of the picture's sides: as large as leaves time for samples.
  double scale() const { return kScales[step_]; }
  // A frame that has gone on for `elapsed` seconds: how long it may sample, and how many paths that
  // is, as far as the last frames can tell.
  double sampling_seconds(double elapsed) const {
    return std::max(seconds_ - elapsed - after_, kLeastShare * seconds_);
  }
  // Of a camera that rests: no less than the picture takes afterwards, so that it gets on where
  // recovery takes long.
  double resting_seconds(double elapsed) const {
    return std::max(sampling_seconds(elapsed), after_);
  }
  double paths(double elapsed) const { return sampling_seconds(elapsed) * paths_per_second_; }

  // Nothing is known of what is to be seen, in `pixels` of full size: as large as leaves time for a
  // path in each. Few paths in a large picture would be a mosaic.
  void begin_anew(double pixels) {
    few_ = many_ = 0;
    for (step_ = 0; step_ + 1 < kSteps && paths(0) < pixels * scale() * scale();) ++step_;
  }

  void sampled(double paths, double seconds) {
    if (paths >= kLeastPaths && seconds > 0)
      paths_per_second_ += kFollow * (paths / seconds - paths_per_second_);
  }
  void finished(double after_sampling) { after_ += kFollow * (after_sampling - after_); }
  // `paths_per_block`: what a moving frame could afford. The scale changes where that was too few
  // or many for some frames.
  void judge_scale(double paths_per_block) {
    few_ = paths_per_block < kLeastPathsPerBlock ? few_ + 1 : 0;
    many_ = paths_per_block > kMostPathsPerBlock ? many_ + 1 : 0;
    if (few_ >= kFewFrames && step_ + 1 < kSteps) ++step_, few_ = 0;
    if (many_ >= kManyFrames && step_ > 0) --step_, many_ = 0;
  }

 private:
  static constexpr double kScales[] = {1, 0.75, 0.5, 0.375, 0.25};
  static constexpr int kSteps = 5, kFewFrames = 2, kManyFrames = 12;
  static constexpr double kFollow = 0.3, kLeastShare = 0.2, kLeastPaths = 1000;
  // Few paths show less than few pixels: edges of lights cost most. A larger picture has up to 16/9
  // as many blocks, which take time away from paths, too.
  static constexpr double kLeastPathsPerBlock = 0.15, kMostPathsPerBlock = 1.2;

  double seconds_;
  double paths_per_second_ = 300'000, after_ = 0;
  int step_ = 0, few_ = 0, many_ = 0;
};

}  // namespace qray
