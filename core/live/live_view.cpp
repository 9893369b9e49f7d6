#include "core/live/live_view.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "core/math/hash.h"

namespace qray {
namespace {

constexpr int kTileBlocks = Film::kTilePx / 2;
constexpr double kSettlingSeconds = 1;
constexpr double kMostLearning = 0.08;   // of the time
constexpr double kForget = 0.9;          // of times, each frame
constexpr uint64_t kLeastSeen = 50'000;  // events: a table that saw fewer makes noise
constexpr float kFewSamples = 4;         // of a block: it gets more
constexpr double kMoreForFew = 3;        // times as many
constexpr int kMostPerBlock = 16;
constexpr double kMostFade = 16;
constexpr uint64_t kMovingSeed = 0x6c697665;  // other samples than those of a camera at rest
// Of a block, in the order in which a resting camera's samples come.
constexpr int kPhaseX[] = {0, 1, 1, 0}, kPhaseY[] = {0, 1, 0, 1};

int even_part(int side, double scale) {
  return std::max(2, static_cast<int>(std::lround(side * scale / 2)) * 2);
}

}  // namespace

struct LiveView::Worker {
  PathTracer tracer;
  std::vector<Rgb> light;  // of each sample
  std::vector<size_t> pixels;
};

std::string_view live_stage_name(LiveStage stage) {
  if (stage == LiveStage::kMoving) return "moving";
  return stage == LiveStage::kSettling ? "settling" : "still";
}

LiveView::LiveView(std::shared_ptr<const PreparedScene> scene, LiveSettings settings,
                   std::unique_ptr<Guide> guide, Network network, TaskPool& pool,
                   const Clock& clock)
    : scene_(std::move(scene)),
      settings_(std::move(settings)),
      guide_(std::move(guide)),
      network_(std::move(network)),
      pool_(pool),
      clock_(clock),
      budget_(settings_.frame_seconds) {
  if (!settings_.render.camera) settings_.render.camera = scene_->scene.camera;
}

void LiveView::set_camera(const Camera& camera) {
  if (*settings_.render.camera == camera) return;
  settings_.render.camera = camera;
  looked_ = false;
  film_.reset();
}

void LiveView::set_switches(const LiveSwitches& switches) {
  if (switches_ == switches) return;
  switches_ = switches;
  looked_ = false;
  film_.reset();
}

void LiveView::set_scene(std::shared_ptr<const PreparedScene> scene) {
  scene_ = std::move(scene);
  if (guide_) guide_->doubt();
  history_.clear();
  view_ = {};
  looked_ = false;
  film_.reset();
}

// Sees where the camera is now, and what is known of it.
void LiveView::look(LiveFrame& frame) {
  const double start = clock_.seconds();
  const RenderSettings& s = settings_.render;
  const int width = even_part(s.width, budget_.scale());
  const int height = even_part(s.height, budget_.scale());
  const ViewBuffer before = std::move(view_);
  if (before.width != width || before.height != height) {
    recovery_.reset();
    blocks_.reset();
    next_sample_.assign(static_cast<size_t>(width) * static_cast<size_t>(height), 0);
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
    history_.assign(static_cast<size_t>(width) * static_cast<size_t>(height), {});
  }
  frame.times.reprojection = clock_.seconds() - seen;
}

float LiveView::deviation(int x, int y) const {
  if (!blocks_ || x / 2 >= blocks_->width()) return 0;
  return std::sqrt(blocks_->of_pixel(x, y).variance) * luminance(view_.albedo(view_.index(x, y)));
}

std::unique_ptr<GuideDelta> LiveView::empty_delta() {
  if (free_deltas_.empty()) return guide_->make_delta();
  std::unique_ptr<GuideDelta> delta = std::move(free_deltas_.back());
  free_deltas_.pop_back();
  return delta;
}

bool LiveView::learns_now() const {
  return guide_ && switches_.learning &&
         (settings_.paths_per_block > 0 ||
          learning_seconds_ <= kMostLearning * (learning_seconds_ + other_seconds_));
}

void LiveView::learn(LiveFrame& frame, std::vector<std::unique_ptr<GuideDelta>>& deltas,
                     size_t count) {
  const double start = clock_.seconds();
  for (size_t i = 0; i < std::min(count, deltas.size()); ++i) {
    if (!deltas[i]) continue;
    guide_->update(*deltas[i]);
    free_deltas_.push_back(std::move(deltas[i]));
  }
  if (guide_ && !deltas.empty()) guide_->end_pass();
  frame.times.learning = clock_.seconds() - start;
}

double LiveView::more_for_few() const {
  return settings_.render.pixels == Pixels::kAdaptive ? kMoreForFew : 1;
}

void LiveView::sample_tile(int tile, double per_block, uint64_t frame, Worker& worker,
                           GuideDelta* delta) {
  const int across = (view_.width / 2 + kTileBlocks - 1) / kTileBlocks;
  const int bx0 = tile % across * kTileBlocks, by0 = tile / across * kTileBlocks;
  const int bx1 = std::min(bx0 + kTileBlocks, view_.width / 2);
  const int by1 = std::min(by0 + kTileBlocks, view_.height / 2);
  worker.light.clear();
  worker.pixels.clear();
  for (int by = by0; by < by1; ++by)
    for (int bx = bx0; bx < bx1; ++bx) {
      const size_t first = view_.index(2 * bx, 2 * by), row = static_cast<size_t>(view_.width);
      const size_t pixels[] = {first, first + 1, first + row, first + row + 1};
      // A whole number by chance, so that its mean is what was wanted.
      const auto whole = [](double wanted, uint64_t bits) {
        return static_cast<int>(std::min<double>(wanted, kMostPerBlock) +
                                to_unit_float(static_cast<uint32_t>(bits >> 32)));
      };
      if (settings_.render.pixels == Pixels::kAll) {
        for (const size_t pixel : pixels)
          for (int n = whole(per_block / 4, mix64(frame << 32 ^ pixel)); n > 0; --n)
            worker.pixels.push_back(pixel);
        continue;
      }
      float has[4], sum = 0;
      for (int k = 0; k < 4; ++k) sum += has[k] = history_[pixels[k]].samples;
      const uint64_t bits = mix64(frame << 32 ^ first);
      const int count = whole(sum < kFewSamples ? per_block * more_for_few() : per_block, bits);
      for (int n = 0; n < count; ++n) {
        // The pixel that has the fewest; of several, another one each frame.
        int least = static_cast<int>(bits & 3);
        for (int k = 0; k < 4; ++k)
          if (has[k] < has[least]) least = k;
        has[least] += 1;
        worker.pixels.push_back(pixels[least]);
      }
    }
  worker.light.resize(worker.pixels.size());
  Sampler sampler(settings_.render.seed ^ kMovingSeed);
  for (size_t i = 0; i < worker.pixels.size(); ++i) {
    const size_t pixel = worker.pixels[i];
    const int x = static_cast<int>(pixel % static_cast<size_t>(view_.width));
    const int y = static_cast<int>(pixel / static_cast<size_t>(view_.width));
    sampler.start(static_cast<uint32_t>(x), static_cast<uint32_t>(y), next_sample_[pixel]++);
    const Vec2 in_pixel = sampler.next_2d();
    const Vec2 lens = view_.camera.has_lens() ? sampler.next_2d() : Vec2{};
    worker.tracer.sample(
        view_.camera.ray({static_cast<float>(x) + in_pixel.x, static_cast<float>(y) + in_pixel.y},
                         lens),
        sampler, delta, deviation(x, y), worker.light[i]);
  }
  worker.tracer.flush();
  for (size_t i = 0; i < worker.pixels.size(); ++i)
    history_[worker.pixels[i]].add(worker.light[i] / view_.albedo(worker.pixels[i]));
}

void LiveView::sample_moving(LiveFrame& frame, std::vector<Worker>& workers, double elapsed,
                             std::stop_token stop) {
  const double blocks = view_.width * view_.height / 4.0;
  double few = 0;
  for (int y = 0; y < view_.height; y += 2)
    for (int x = 0; x < view_.width; x += 2) {
      const size_t i = view_.index(x, y), below = view_.index(x, y + 1);
      few += history_[i].samples + history_[i + 1].samples + history_[below].samples +
                 history_[below + 1].samples <
             kFewSamples;
    }
  const double affordable =
      settings_.paths_per_block > 0 ? settings_.paths_per_block : budget_.paths(elapsed) / blocks;
  // Where much has just come into view, everything gets less.
  const double share = few / blocks;
  const double per_block = affordable / (1 + (more_for_few() - 1) * share);
  const int tiles = ((view_.width / 2 + kTileBlocks - 1) / kTileBlocks) *
                    ((view_.height / 2 + kTileBlocks - 1) / kTileBlocks);
  const bool learns = learns_now();
  std::vector<std::unique_ptr<GuideDelta>> deltas(learns ? static_cast<size_t>(tiles) : 0);
  for (auto& delta : deltas) delta = empty_delta();
  const double start = clock_.seconds();
  pool_.run(static_cast<size_t>(tiles), [&](size_t tile, int worker) {
    if (!stop.stop_requested())
      sample_tile(static_cast<int>(tile), per_block, frame.number,
                  workers[static_cast<size_t>(worker)], learns ? deltas[tile].get() : nullptr);
  });
  frame.times.samples = clock_.seconds() - start;
  learn(frame, deltas, deltas.size());
  if (settings_.paths_per_block == 0) budget_.judge_scale(affordable);
}

// A quarter of a tile's pixels get one sample more: the very samples that a job takes.
void LiveView::sample_film(uint64_t unit, Worker& worker, GuideDelta* delta) {
  const auto tiles = static_cast<uint64_t>(film_->tile_count());
  const int tile = static_cast<int>(unit % tiles);
  const size_t phase = unit / tiles % 4;
  const uint32_t pass = static_cast<uint32_t>(unit / tiles / 4);
  const TileRect rect = film_->tile(tile);
  const CameraRays camera(*settings_.render.camera, settings_.render.width,
                          settings_.render.height);
  const bool in_view = view_.width == settings_.render.width;
  std::vector<Rgb> sums(static_cast<size_t>(rect.width) * static_cast<size_t>(rect.height));
  std::vector<uint32_t> counts(sums.size());
  Sampler sampler(settings_.render.seed);
  for (int y = rect.y + kPhaseY[phase]; y < rect.y + rect.height; y += 2)
    for (int x = rect.x + kPhaseX[phase]; x < rect.x + rect.width; x += 2) {
      const size_t i = static_cast<size_t>(y - rect.y) * static_cast<size_t>(rect.width) +
                       static_cast<size_t>(x - rect.x);
      counts[i] = 1;
      sampler.start(static_cast<uint32_t>(x), static_cast<uint32_t>(y), pass);
      const Vec2 in_pixel = sampler.next_2d();
      const Vec2 lens = camera.has_lens() ? sampler.next_2d() : Vec2{};
      worker.tracer.sample(
          camera.ray({static_cast<float>(x) + in_pixel.x, static_cast<float>(y) + in_pixel.y},
                     lens),
          sampler, delta, noise_->deviation(x, y), sums[i]);
    }
  worker.tracer.flush();
  film_->add(tile, sums, phase == 0 ? 1 : 0, counts);
  for (size_t i = 0; i < sums.size(); ++i) {
    if (counts[i] == 0) continue;
    const float v = luminance(sums[i]);
    noise_->add(rect.x + static_cast<int>(i) % rect.width,
                rect.y + static_cast<int>(i) / rect.width, pass, 1, pass % 2 ? 0.0f : v,
                pass % 2 ? v : 0.0f);
  }
  if (!in_view || !switches_.reprojection) return;
  for (size_t i = 0; i < sums.size(); ++i) {
    if (counts[i] == 0) continue;
    const size_t pixel = view_.index(rect.x + static_cast<int>(i) % rect.width,
                                     rect.y + static_cast<int>(i) / rect.width);
    if (!view_.emitted.empty() && !view_.emitted[pixel].is_black()) continue;  // is in the sample
    history_[pixel].add(sums[i] / view_.albedo(pixel));
  }
}

// As in a job, passes weigh as much as their noise while the guide gets better.
void LiveView::end_pass(bool guide_changes) {
  if (!noise_->end_pass()) return;
  noise_level_ = noise_->level();
  if (!guide_changes) return;
  const double now = noise_->variance(), before = noise_->variance_before();
  if (now > 0 && before > 0)
    film_->fade(static_cast<float>(std::clamp(now / before, 1 / kMostFade, kMostFade)));
}

void LiveView::sample_resting(LiveFrame& frame, std::vector<Worker>& workers, double elapsed,
                              std::stop_token stop) {
  const size_t tiles = static_cast<size_t>(film_->tile_count());
  const bool fixed = settings_.paths_per_block > 0;
  const size_t most =
      fixed ? static_cast<size_t>(std::max(1.0, std::round(settings_.paths_per_block)))
            : kMostPerBlock;
  // A frame ends with its pass, so that what comes next knows the noise of what was.
  const uint64_t in_pass = 4 * tiles, begun = next_unit_ % in_pass;
  const size_t units = std::min(tiles * most, static_cast<size_t>(in_pass - begun));
  if (begun == 0) noise_->start_pass(frame.guided);
  const bool learns = learns_now();
  std::vector<std::unique_ptr<GuideDelta>> deltas(learns ? units : 0);
  std::mutex mutex;
  const double start = clock_.seconds();
  const double end = start + budget_.sampling_seconds(elapsed);
  const size_t done = pool_.run_until(
      units,
      [&](size_t i, int worker) {
        std::unique_ptr<GuideDelta> delta;
        if (learns) {
          std::lock_guard lock(mutex);
          delta = empty_delta();
        }
        sample_film(next_unit_ + i, workers[static_cast<size_t>(worker)], delta.get());
        if (learns) deltas[i] = std::move(delta);
      },
      [&] { return stop.stop_requested() || (!fixed && clock_.seconds() >= end); });
  next_unit_ += done;
  frame.times.samples = clock_.seconds() - start;
  learn(frame, deltas, done);
  if (begun + done == in_pass) end_pass(frame.guided && learns);
}

std::optional<LiveFrame> LiveView::next_frame(std::stop_token stop) {
  const double start = clock_.seconds();
  LiveFrame frame;
  frame.number = ++frames_;

  // 1. What is seen. A camera that has not moved since the last frame rests from now on.
  const bool resting = looked_;
  if (!resting) {
    look(frame);
    looked_ = true;
  } else if (!film_) {
    film_.emplace(settings_.render.width, settings_.render.height);
    noise_.emplace(settings_.render.width, settings_.render.height);
    next_unit_ = 0;
    noise_level_ = 0;
    resting_since_ = start;
  }

  // 2. Samples, and what the guide learns of them.
  frame.guided = guide_ && switches_.learning && guide_->stats().samples_seen >= kLeastSeen;
  std::vector<Worker> workers;
  for (int i = 0; i < pool_.threads(); ++i) {
    workers.push_back({{*scene_, scene_->lights, settings_.render, guide_.get()}, {}, {}});
    workers.back().tracer.set_guiding(frame.guided                   ? PathTracer::Guiding::kOn
                                      : guide_ && switches_.learning ? PathTracer::Guiding::kWatch
                                                                     : PathTracer::Guiding::kOff);
    if (!resting && !view_.emitted.empty()) workers.back().tracer.hide_lights_seen_directly();
  }
  if (resting) {
    sample_resting(frame, workers, clock_.seconds() - start, stop);
  } else {
    sample_moving(frame, workers, clock_.seconds() - start, stop);
  }
  if (stop.stop_requested()) return {};
  for (const Worker& worker : workers) {
    frame.paths += worker.tracer.counters().paths;
    frame.rays += worker.tracer.counters().rays;
  }
  if (!resting) frame.rays += view_.points.size();  // its features'
  budget_.sampled(static_cast<double>(frame.paths), frame.times.samples);

  // 3. The picture.
  const double sampled = clock_.seconds();
  const uint64_t whole_passes =
      film_ ? next_unit_ / (4 * static_cast<uint64_t>(film_->tile_count())) : 0;
  if (resting && whole_passes >= 1 && start - resting_since_ >= kSettlingSeconds) {
    frame.stage = LiveStage::kStill;
    frame.picture = film_->develop();
    frame.noise = noise_level_;
    frame.samples_per_pixel =
        static_cast<double>(next_unit_) / (4 * static_cast<double>(film_->tile_count()));
  } else {
    frame.stage = resting ? LiveStage::kSettling : LiveStage::kMoving;
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
  const double end = clock_.seconds();
  frame.times.recovery = end - sampled;
  frame.times.whole = end - start;
  budget_.finished(frame.times.learning + frame.times.recovery);
  learning_seconds_ = kForget * learning_seconds_ + frame.times.learning;
  other_seconds_ = kForget * other_seconds_ + frame.times.whole - frame.times.learning;
  return frame;
}

}  // namespace qray
