#include "core/live/live_view.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace qray {
namespace {

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
      recovery_(std::move(network)),
      pool_(pool),
      clock_(clock),
      budget_(settings_.frame_seconds),
      moving_(settings_.render, guide_.active(), clock) {
  settings_.render.adaptive.caustics = false;  // photons would delay each change of a light
  if (!settings_.render.camera) settings_.render.camera = scene_->scene.camera;
}

void LiveView::forget_view() {
  looked_ = false;
  if (resting_) history_ = resting_->known(history_);
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
  guide_.scene_changed(scene_->guide_setup(settings_.render).lights);
  history_.clear();
  view_ = {};
  anew_ = true;
}

// Sees where the camera is now, and what is known of it.
void LiveView::look(LiveFrame& frame, double scale) {
  const double start = clock_.seconds();
  const RenderSettings& s = settings_.render;
  const int width = even_part(s.width, scale), height = even_part(s.height, scale);
  const size_t pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
  const ViewBuffer before = std::move(view_);
  if (before.width != width || before.height != height) {
    blocks_.reset();
    moving_.size_changed(pixels);
  }
  if (switches_.recovery || switches_.reprojection) {
    view_ = see_view(*scene_, *s.camera, width, height, pool_);
  } else {
    view_ = {width, height, CameraRays(*s.camera, width, height), {}, {}, {}, {}, {}};
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
  RenderWorkers workers(*scene_, settings_.render, guide_.active(), pool_);
  workers.set_guiding(frame.guided, learns);
  if (!view_.emitted.empty()) workers.hide_lights_seen_directly();
  const double blocks = view_.width * view_.height / 4.0;
  const double affordable = fixed() ? settings_.paths_per_block : budget_.paths(elapsed) / blocks;
  GuidedPixels guide{.guided = frame.guided, .learning = learns, .pass = frame.number};
  guide.few = learns && guide_.learns_from_few(static_cast<uint64_t>(affordable * blocks));
  const double updates_before = moving_.update_seconds();
  moving_.sample({view_, history_, blocks_ ? &*blocks_ : nullptr, frame.number, affordable, guide},
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

// The camera has not moved since the last frame. It is seen in full size from now on.
void LiveView::rest(LiveFrame& frame) {
  if (resting_) return;
  if (view_.width != settings_.render.width) look(frame, 1);
  resting_.emplace(*scene_, settings_.render, guide_.active(), view_, pool_, clock_);
}

void LiveView::sample_resting(LiveFrame& frame, double elapsed, const std::stop_token& stop) {
  const double before_rest = clock_.seconds();
  rest(frame);
  const Renderer& renderer = resting_->renderer();
  const double start = clock_.seconds(), learning_before = renderer.learning_seconds();
  const double end = start + budget_.resting_seconds(elapsed + start - before_rest);
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

// Nothing of earlier views is in the picture any more.
bool LiveView::is_still() const {
  return resting_ && resting_->renderer().samples_per_pixel() >= kSamplesWithoutMoved;
}

// Blocks' samples stand for those of their pixels until each has some.
bool LiveView::knows_pixels() const {
  constexpr int kFewSamples = 4;
  return resting_ && resting_->renderer().samples_per_pixel() >= kFewSamples;
}

void LiveView::show_samples(LiveFrame& frame) {
  frame.picture = resting_->picture();
  frame.noise = resting_->renderer().progress().noise;
  frame.samples_per_pixel = resting_->renderer().samples_per_pixel();
}

void LiveView::show_known(LiveFrame& frame) {
  const History known = resting_ ? resting_->known(history_) : history_;
  blocks_.emplace(view_, known, pool_);
  frame.noise = blocks_->noise();
  if (recovers()) {
    frame.picture =
        recovered_picture(view_, known, *blocks_, knows_pixels(), recovery_, history_, pool_);
  } else {
    frame.picture = sampled_picture(view_, known, *blocks_, pool_);
  }
  frame.scale = static_cast<double>(view_.width) / settings_.render.width;
  frame.picture = enlarged(frame.picture, settings_.render.width, settings_.render.height, pool_);
  if (!view_.emitted.empty())
    add_emitted(*scene_, view_, *settings_.render.camera, frame.picture, pool_);
  if (frame.stage == LiveStage::kStill) resting_->put_lights(frame.picture);
  double samples = 0;
  for (const PixelHistory& h : known) samples += static_cast<double>(h.samples);
  frame.samples_per_pixel = samples / static_cast<double>(known.size());
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
    const RenderSettings& s = settings_.render;
    if (std::exchange(anew_, false) && !fixed()) budget_.begin_anew(1.0 * s.width * s.height);
    look(frame, budget_.scale());
    sample_moving(frame, clock_.seconds() - start, stop);
  }
  if (stop.stop_requested()) {
    forget_view();  // what was sampled is not whole
    return {};
  }
  const double sampled = clock_.seconds();
  budget_.sampled(static_cast<double>(frame.paths), frame.times.samples);

  // 2. The picture.
  if (resting_) frame.stage = is_still() ? LiveStage::kStill : LiveStage::kSettling;
  if (frame.stage == LiveStage::kStill && !recovers()) {
    show_samples(frame);
  } else {
    show_known(frame);
  }
  const double end = clock_.seconds();
  frame.times.recovery = end - sampled;
  frame.times.whole = end - start;
  budget_.finished(frame.times.learning + frame.times.recovery);
  guide_.frame_took(frame.times.learning, frame.times.whole - frame.times.learning);
  return frame;
}

}  // namespace qray
