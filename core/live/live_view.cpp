#include "core/live/live_view.h"

#include <algorithm>
#include <cmath>

namespace qray {
namespace {

constexpr double kSettlingSeconds = 1;

int even_part(int side, double scale) {
  return std::max(2, static_cast<int>(std::lround(side * scale / 2)) * 2);
}

}  // namespace

std::string_view live_stage_name(LiveStage stage) {
  if (stage == LiveStage::kMoving) return "moving";
  return stage == LiveStage::kSettling ? "settling" : "still";
}

LiveView::LiveView(std::shared_ptr<const PreparedScene> scene, LiveSettings settings,
                   std::unique_ptr<Guide> guide, Network network, TaskPool& pool,
                   const Clock& clock)
    : scene_(std::move(scene)),
      settings_(std::move(settings)),
      guide_(std::move(guide), settings_.render.gate),
      network_(std::move(network)),
      pool_(pool),
      clock_(clock),
      budget_(settings_.frame_seconds),
      moving_(settings_.render, guide_.active(), clock) {
  if (!settings_.render.camera) settings_.render.camera = scene_->scene.camera;
}

void LiveView::forget_view() {
  looked_ = false;
  resting_.reset();
}

void LiveView::set_camera(const Camera& camera) {
  if (*settings_.render.camera == camera) return;
  settings_.render.camera = camera;
  forget_view();
}

void LiveView::set_switches(const LiveSwitches& switches) {
  if (switches_ == switches) return;
  switches_ = switches;
  guide_.switch_to(switches.learning);
  forget_view();
}

void LiveView::set_scene(std::shared_ptr<const PreparedScene> scene) {
  forget_view();
  scene_ = std::move(scene);
  guide_.scene_changed();
  history_.clear();
  view_ = {};
}

// Sees where the camera is now, and what is known of it.
void LiveView::look(LiveFrame& frame) {
  const double start = clock_.seconds();
  const RenderSettings& s = settings_.render;
  const int width = even_part(s.width, budget_.scale());
  const int height = even_part(s.height, budget_.scale());
  const size_t pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
  const ViewBuffer before = std::move(view_);
  if (before.width != width || before.height != height) {
    recovery_.reset();
    blocks_.reset();
    moving_.size_changed(pixels);
  }
  if (switches_.recovery || switches_.reprojection) {
    view_ = see_view(*scene_, *s.camera, width, height, pool_);
  } else {
    view_ = {width, height, CameraRays(*s.camera, width, height), {}, {}, {}, {}};
  }
  const double seen = clock_.seconds();
  frame.times.features = seen - start;
  if (switches_.reprojection && !before.empty() && !history_.empty()) {
    history_ = reproject(before, history_, view_, pool_);
  } else {
    history_.assign(pixels, {});
  }
  frame.times.reprojection = clock_.seconds() - seen;
  looked_ = true;
}

void LiveView::sample_moving(LiveFrame& frame, double elapsed, const std::stop_token& stop) {
  const double start = clock_.seconds();
  frame.guided = guide_.guides();
  const bool learns = guide_.learns(/*whatever_time=*/fixed());
  RenderWorkers workers(*scene_, settings_.render, guide_.active(), pool_.threads());
  workers.set_guiding(frame.guided, learns);
  if (!view_.emitted.empty()) workers.hide_lights_seen_directly();
  const double blocks = view_.width * view_.height / 4.0;
  const double affordable = fixed() ? settings_.paths_per_block : budget_.paths(elapsed) / blocks;
  const double updates_before = moving_.update_seconds();
  moving_.sample({view_, history_, blocks_ ? &*blocks_ : nullptr, frame.number, affordable, learns},
                 workers, pool_, stop);
  const double sampled = clock_.seconds();
  frame.times.learning = (moving_.update_seconds() - updates_before) / pool_.threads();
  frame.times.samples = sampled - start - frame.times.learning;
  if (learns) guide_.active()->end_pass();
  frame.times.learning += clock_.seconds() - sampled;
  frame.paths = workers.counters().paths;
  frame.rays = workers.counters().rays + view_.points.size();  // its features'
  if (!fixed()) budget_.judge_scale(affordable);
}

// The camera has not moved since the last frame.
void LiveView::rest() {
  if (resting_) return;
  std::function<void(const TileSamples&)> on_samples;
  if (view_.width == settings_.render.width && switches_.reprojection)
    on_samples = [this](const TileSamples& samples) { add_to_history(samples); };
  resting_.emplace(*scene_, settings_.render, guide_.active(), pool_, clock_,
                   std::move(on_samples));
}

void LiveView::add_to_history(const TileSamples& samples) {
  const TileRect& rect = samples.rect();
  for (int y = rect.y; y < rect.y + rect.height; ++y)
    for (int x = rect.x; x < rect.x + rect.width; ++x) {
      if (samples.count(x, y) == 0) continue;
      const size_t pixel = view_.index(x, y);
      // What lights show of themselves is in the sample, not in the history.
      if (!view_.emitted.empty() && !view_.emitted[pixel].is_black()) continue;
      history_[pixel].add(samples.sum(x, y) / view_.albedo(pixel));
    }
}

void LiveView::sample_resting(LiveFrame& frame, double elapsed, const std::stop_token& stop) {
  rest();
  const Renderer& renderer = resting_->renderer();
  const double start = clock_.seconds(), learning_before = renderer.learning_seconds();
  const double end = start + budget_.sampling_seconds(elapsed);
  const PathCounters before = renderer.counters();
  const size_t most = fixed() ? resting_->tiles() * static_cast<size_t>(std::max(
                                                        1.0, std::round(settings_.paths_per_block)))
                              : renderer.units();
  resting_->sample(
      most, guide_.has_time(/*whatever_time=*/fixed()),
      [&] { return stop.stop_requested() || (!fixed() && clock_.seconds() >= end); }, stop);
  frame.times.learning = renderer.learning_seconds() - learning_before;
  frame.times.samples = clock_.seconds() - start - frame.times.learning;
  frame.guided = renderer.guided();
  if (renderer.decision()) guide_.judged(*renderer.decision());
  frame.paths = renderer.counters().paths - before.paths;
  frame.rays = renderer.counters().rays - before.rays;
}

bool LiveView::shows_still(double now) const {
  return resting_ && resting_->renderer().samples_per_pixel() >= 1 &&
         now - resting_->since() >= kSettlingSeconds;
}

void LiveView::show_still(LiveFrame& frame) {
  frame.stage = LiveStage::kStill;
  frame.picture = resting_->picture();
  frame.noise = resting_->renderer().progress().noise;
  frame.samples_per_pixel = resting_->renderer().samples_per_pixel();
}

void LiveView::show_recovered(LiveFrame& frame) {
  frame.stage = resting_ ? LiveStage::kSettling : LiveStage::kMoving;
  blocks_.emplace(view_, history_, pool_);
  frame.noise = blocks_->noise();
  if (switches_.recovery && network_.hidden > 0) {
    if (!recovery_) recovery_.emplace(network_, view_.width, view_.height);
    frame.picture = recovered_picture(view_, history_, *blocks_, *recovery_, pool_);
  } else {
    frame.picture = sampled_picture(view_, history_, *blocks_, pool_);
  }
  frame.scale = static_cast<double>(view_.width) / settings_.render.width;
  frame.picture = enlarged(frame.picture, settings_.render.width, settings_.render.height, pool_);
  if (!view_.emitted.empty())
    add_emitted(*scene_, view_, *settings_.render.camera, frame.picture, pool_);
  double samples = 0;
  for (const PixelHistory& h : history_) samples += static_cast<double>(h.samples);
  frame.samples_per_pixel = samples / static_cast<double>(history_.size());
}

std::optional<LiveFrame> LiveView::next_frame(std::stop_token stop) {
  const double start = clock_.seconds();
  LiveFrame frame;
  frame.number = ++frames_;

  // 1. What is seen, and samples of it, of which the guide learns. A camera that has not moved
  // since the last frame rests from now on.
  if (looked_) {
    sample_resting(frame, clock_.seconds() - start, stop);
  } else {
    look(frame);
    sample_moving(frame, clock_.seconds() - start, stop);
  }
  if (stop.stop_requested()) {
    forget_view();  // what was sampled is not whole
    return {};
  }
  const double sampled = clock_.seconds();
  budget_.sampled(static_cast<double>(frame.paths), frame.times.samples);

  // 2. The picture.
  if (shows_still(start)) {
    show_still(frame);
  } else {
    show_recovered(frame);
  }
  const double end = clock_.seconds();
  frame.times.recovery = end - sampled;
  frame.times.whole = end - start;
  budget_.finished(frame.times.learning + frame.times.recovery);
  guide_.frame_took(frame.times.learning, frame.times.whole - frame.times.learning);
  return frame;
}

}  // namespace qray
