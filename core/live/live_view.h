// A walk through a scene, frame by frame, each within a budget of time: a camera that moves gets
// what few samples show of it, made whole by what earlier frames saw and by recovery; one that
// rests gets samples alone, and with time the exact picture. The guide learns all the while.
// One thread calls; the pool's work.
#pragma once

#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

#include "core/base/clock.h"
#include "core/film/film.h"
#include "core/live/frame_budget.h"
#include "core/live/live_picture.h"
#include "core/render/noise_estimate.h"
#include "core/render/path.h"

namespace qray {

struct LiveSwitches {
  bool learning = true, recovery = true, reprojection = true;
  bool operator==(const LiveSwitches&) const = default;
};

struct LiveSettings {
  // Method, size (even), seed, depth; how many samples is not asked. `pixels` is of a camera that
  // moves: kAll, each as often as any other; kQuarter, each block of 2 x 2, whose pixels take
  // turns; kAdaptive, blocks of which little is known more often.
  RenderSettings render;
  double frame_seconds = 0.1;
  // > 0: in each moving frame, and of as many of a resting frame's pixels, whatever time that
  // takes: the same frames for any number of threads.
  double paths_per_block = 0;
};

// What a frame shows.
enum class LiveStage {
  kMoving,    // history and recovery
  kSettling,  // the same, of a camera that rests
  kStill,     // the samples since it rests alone
};
std::string_view live_stage_name(LiveStage stage);  // moving, settling, still

struct LiveTimes {  // seconds
  double features = 0, reprojection = 0, samples = 0, learning = 0, recovery = 0, whole = 0;
};

struct LiveFrame {
  uint64_t number = 0;  // from 1 on
  LiveStage stage = LiveStage::kMoving;
  Image picture;     // linear
  double scale = 1;  // sides of what was rendered over the picture's: less where time is short
  LiveTimes times;
  uint64_t paths = 0, rays = 0;
  bool guided = false;
  double samples_per_pixel = 0;  // in the picture, on average
  double noise = 0;              // of the samples in it, relative, before recovery; 0: not known
};

class LiveView {
 public:
  // `guide`: null, nothing is learned. `network`: of no units, no recovery.
  LiveView(std::shared_ptr<const PreparedScene> scene, LiveSettings settings,
           std::unique_ptr<Guide> guide, Network network, TaskPool& pool, const Clock& clock);

  void set_camera(const Camera& camera);
  void set_switches(const LiveSwitches& switches);
  // The same surfaces under other light: nothing that was sampled holds, what was learned hardly.
  void set_scene(std::shared_ptr<const PreparedScene> scene);

  // nullopt: stopped.
  std::optional<LiveFrame> next_frame(std::stop_token stop = {});

  const PreparedScene& scene() const { return *scene_; }
  const RenderSettings& settings() const { return settings_.render; }
  const Guide* guide() const { return guide_.get(); }
  std::unique_ptr<Guide> take_guide() { return std::move(guide_); }

 private:
  struct Worker;
  void look(LiveFrame& frame);
  void sample_moving(LiveFrame& frame, std::vector<Worker>& workers, double elapsed,
                     std::stop_token stop);
  void sample_resting(LiveFrame& frame, std::vector<Worker>& workers, double elapsed,
                      std::stop_token stop);
  void end_pass(bool guide_changes);
  void sample_tile(int tile, double per_block, uint64_t frame, Worker& worker, GuideDelta* delta);
  void sample_film(uint64_t unit, Worker& worker, GuideDelta* delta);
  void learn(LiveFrame& frame, std::vector<std::unique_ptr<GuideDelta>>& deltas, size_t count);
  float deviation(int x, int y) const;
  double more_for_few() const;  // samples of a block of which little is known, over others'
  std::unique_ptr<GuideDelta> empty_delta();
  bool learns_now() const;

  std::shared_ptr<const PreparedScene> scene_;
  LiveSettings settings_;
  std::unique_ptr<Guide> guide_;
  Network network_;
  TaskPool& pool_;
  const Clock& clock_;
  LiveSwitches switches_;
  FrameBudget budget_;

  uint64_t frames_ = 0;
  bool looked_ = false;  // view_ is of the settings' camera
  ViewBuffer view_;
  History history_;
  std::optional<BlockGrid> blocks_;
  std::optional<FastRecovery> recovery_;
  std::vector<uint32_t> next_sample_;  // by pixel of view_

  // Of a camera that rests.
  std::optional<Film> film_;
  std::optional<NoiseEstimate> noise_;  // of the film
  double noise_level_ = 0;              // as of the last whole pass
  double resting_since_ = 0;
  uint64_t next_unit_ = 0;  // a quarter of a tile's pixels, once

  std::vector<std::unique_ptr<GuideDelta>> free_deltas_;
  double learning_seconds_ = 0, other_seconds_ = 0;  // of the last frames
};

}  // namespace qray
