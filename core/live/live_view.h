// A walk through a scene, frame by frame, each within a budget of time. A frame is made of few
// samples, of what earlier frames saw, and of recovery. Where the camera rests its samples displace
// both, each pixel's as they become sure, until the picture is exact. The guide learns all the
// while. One thread calls; the pool's work.
#pragma once

#include <memory>
#include <optional>
#include <stop_token>

#include "core/live/frame_budget.h"
#include "core/live/live_guide.h"
#include "core/live/live_picture.h"
#include "core/live/moving_samples.h"
#include "core/live/resting_picture.h"

namespace qray {

class LiveView {
 public:
  // `guide`: null, nothing is learned. `network`: of no units, no recovery.
  LiveView(std::shared_ptr<const PreparedScene> scene, LiveSettings settings,
           std::unique_ptr<Guide> guide, Network network, TaskPool& pool, const Clock& clock);
  LiveView(const LiveView&) = delete;
  LiveView& operator=(const LiveView&) = delete;

  void set_camera(const Camera& camera);
  void set_switches(const LiveSwitches& switches);
  // The same surfaces under other light: nothing that was sampled holds, what was learned hardly.
  void set_scene(std::shared_ptr<const PreparedScene> scene);

  // nullopt: stopped.
  std::optional<LiveFrame> next_frame(std::stop_token stop = {});

  const PreparedScene& scene() const { return *scene_; }
  const RenderSettings& settings() const { return settings_.render; }
  const Guide* guide() const { return guide_.get(); }
  std::unique_ptr<Guide> take_guide() { return guide_.take(); }

 private:
  void forget_view();  // what is seen is another from now on
  void look(LiveFrame& frame, double scale);
  void rest(LiveFrame& frame);
  void sample_moving(LiveFrame& frame, double elapsed, const std::stop_token& stop);
  void sample_resting(LiveFrame& frame, double elapsed, const std::stop_token& stop);
  bool is_still() const;
  bool knows_pixels() const;
  void show_samples(LiveFrame& frame);
  void show_known(LiveFrame& frame);
  bool recovers() const { return switches_.recovery && recovery_.has_network(); }
  bool fixed() const { return settings_.paths_per_block > 0; }

  std::shared_ptr<const PreparedScene> scene_;
  LiveSettings settings_;
  LiveGuide guide_;
  Guess recovery_;
  TaskPool& pool_;
  const Clock& clock_;
  LiveSwitches switches_;
  FrameBudget budget_;

  uint64_t frames_ = 0;
  bool looked_ = false;  // view_ is of the settings' camera
  bool anew_ = true;     // nothing is known of what is seen
  ViewBuffer view_;
  History history_;  // of the frames before the camera came to rest, if it rests
  std::optional<BlockGrid> blocks_;
  MovingSamples moving_;
  std::optional<RestingPicture> resting_;  // while the camera rests
};

}  // namespace qray
