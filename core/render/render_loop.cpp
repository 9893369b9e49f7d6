#include "core/render/render_loop.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <mutex>
#include <numeric>

#include "core/base/check.h"
#include "core/render/path.h"
#include "core/render/pixel_estimate.h"

namespace qray {
namespace {

constexpr int kMaxPassSamples = 64;

// Decides the size of each pass, and what fits the budget. Totals grow by about sqrt 2, so that a
// table is soon of use and a picture of any age is near: 1, 2, 3, 4, 6, 8, 12, 16 ... up to a cap.
class PassPlan {
 public:
  explicit PassPlan(const RenderSettings& settings) : settings_(settings) {
    if (!settings.passes.empty()) {
      total_ = std::accumulate(settings.passes.begin(), settings.passes.end(), int64_t{0});
    } else if (settings.samples > 0) {
      total_ = settings.samples;
    }
  }

  // Samples a pixel of the next pass; 0: the job is done.
  int next(uint64_t done, double elapsed, double last_pass_seconds) const {
    if (!settings_.passes.empty()) {
      return passes_.size() < settings_.passes.size() ? settings_.passes[passes_.size()] : 0;
    }
    int64_t n =
        std::clamp<int64_t>(static_cast<int64_t>(std::bit_floor(done) / 2), 1, kMaxPassSamples);
    if (total_ > 0) n = std::min(n, total_ - static_cast<int64_t>(done));
    if (settings_.seconds > 0 && !passes_.empty()) {
      const double sample_seconds = std::max(last_pass_seconds / passes_.back(), 1e-9);
      const double fits = (settings_.seconds - elapsed) / sample_seconds;
      n = std::min(n, static_cast<int64_t>(std::clamp(fits, 0.0, 1e9)));
    }
    return static_cast<int>(n);
  }
  void started(int samples) { passes_.push_back(samples); }

  bool learning(uint64_t done, double elapsed) const {
    if (done >= static_cast<uint64_t>(settings_.learning_samples)) return false;
    if (!settings_.passes.empty() || done == 0) return true;
    if (settings_.seconds > 0 && elapsed > settings_.seconds / 4) return false;
    return total_ == 0 || done < static_cast<uint64_t>(std::max<int64_t>(1, total_ / 4));
  }

  double fraction(double done, double elapsed) const {
    double f = total_ > 0 ? done / static_cast<double>(total_) : 0;
    if (settings_.passes.empty() && settings_.seconds > 0)
      f = std::max(f, elapsed / settings_.seconds);
    return std::min(f, 1.0);
  }
  const std::vector<int>& passes() const { return passes_; }

 private:
  const RenderSettings& settings_;
  int64_t total_ = 0;  // samples a pixel; 0: by time alone
  std::vector<int> passes_;
};

// Hands tiles' deltas to the guide in tile order, whatever order they finish in. Any thread.
class OrderedUpdates {
 public:
  explicit OrderedUpdates(Guide* guide) : guide_(guide) {}

  std::unique_ptr<GuideDelta> empty_delta() {
    std::lock_guard lock(mutex_);
    if (free_.empty()) return guide_->make_delta();
    std::unique_ptr<GuideDelta> delta = std::move(free_.back());
    free_.pop_back();
    return delta;
  }
  void finish(size_t tile, std::unique_ptr<GuideDelta> delta) {
    std::lock_guard lock(mutex_);
    waiting_[tile] = std::move(delta);
    for (auto first = waiting_.begin(); first != waiting_.end() && first->first == next_;
         first = waiting_.begin(), ++next_) {
      guide_->update(*first->second);
      free_.push_back(std::move(first->second));
      waiting_.erase(first);
    }
  }
  void start_pass() { next_ = 0; }

 private:
  Guide* guide_;
  std::mutex mutex_;
  size_t next_ = 0;
  std::map<size_t, std::unique_ptr<GuideDelta>> waiting_;
  std::vector<std::unique_ptr<GuideDelta>> free_;
};

struct Worker {
  PathTracer tracer;
  std::vector<Rgb> sums;
};

class Renderer {
 public:
  Renderer(const PreparedScene& scene, const RenderSettings& settings, Guide* guide, Film& film,
           TaskPool& pool, RenderObserver& observer, std::stop_token stop, const Clock& clock)
      : scene_(scene),
        settings_(settings),
        guide_(guide),
        film_(film),
        pool_(pool),
        observer_(observer),
        stop_(std::move(stop)),
        clock_(clock),
        camera_(settings.camera.value_or(scene.scene.camera), settings.width, settings.height),
        uniform_lights_(settings.light_table ? LightPick() : scene.lights.uniform()),
        lights_(settings.light_table ? scene.lights : uniform_lights_),
        parts_(parts()),
        plan_(settings),
        updates_(guide) {
    for (int i = 0; i < pool.threads(); ++i)
      workers_.push_back({{scene, lights_, settings, guide}, {}});
  }

  Result<RenderStats> run() {
    start_ = clock_.seconds();
    double last_pass_seconds = 0;
    while (const int samples = plan_.next(done_, elapsed(), last_pass_seconds)) {
      const double pass_start = elapsed();
      learning_ = guide_ && plan_.learning(done_, pass_start);
      plan_.started(samples);
      render_pass(samples);
      if (stop_.stop_requested()) return Error{ErrorCode::kCanceled, "canceled", ""};
      if (learning_) {
        guide_->end_pass();
        learning_done_ += static_cast<uint64_t>(samples);
      }
      done_ += static_cast<uint64_t>(samples);
      last_pass_seconds = elapsed() - pass_start;
      observer_.on_pass(progress(0), stats());
    }
    return stats();
  }

 private:
  double elapsed() const { return clock_.seconds() - start_; }

  RenderProgress progress(double in_pass) const {
    const double now = elapsed();
    return {learning_, plan_.fraction(static_cast<double>(done_) + in_pass, now), done_, now};
  }

  void render_pass(int samples) {
    updates_.start_pass();
    if (guide_ && guide_->expects()) estimate_.update(film_, done_);
    const size_t tiles = static_cast<size_t>(film_.tile_count());
    size_t finished = 0;
    pool_.run(tiles, [&](size_t tile, int worker) {
      if (!render_tile(static_cast<int>(tile), workers_[static_cast<size_t>(worker)], samples))
        return;
      std::lock_guard lock(observer_mutex_);
      ++finished;
      observer_.on_tile(
          progress(samples * static_cast<double>(finished) / static_cast<double>(tiles)));
    });
  }

  // False when stopped; the tile is then left out of the film.
  bool render_tile(int index, Worker& worker, int samples) {
    const TileRect rect = film_.tile(index);
    worker.sums.assign(static_cast<size_t>(rect.width) * static_cast<size_t>(rect.height), Rgb{});
    std::unique_ptr<GuideDelta> delta = learning_ ? updates_.empty_delta() : nullptr;
    Sampler sampler(settings_.seed);
    size_t pixel = 0;
    for (int y = rect.y; y < rect.y + rect.height; ++y) {
      for (int x = rect.x; x < rect.x + rect.width; ++x, ++pixel) {
        if (stop_.stop_requested()) {
          worker.tracer.discard();
          return false;
        }
        for (int s = 0; s < samples; ++s) {
          sampler.start(static_cast<uint32_t>(x), static_cast<uint32_t>(y),
                        static_cast<uint32_t>(done_) + static_cast<uint32_t>(s));
          const Vec2 in_pixel = sampler.next_2d();
          const Vec2 lens = camera_.has_lens() ? sampler.next_2d() : Vec2{};
          const Ray ray = camera_.ray(
              {static_cast<float>(x) + in_pixel.x, static_cast<float>(y) + in_pixel.y}, lens);
          worker.tracer.sample(ray, sampler, delta.get(), estimate_.deviation(x, y),
                               worker.sums[pixel]);
        }
      }
    }
    worker.tracer.flush();
    film_.add(index, worker.sums, static_cast<uint32_t>(samples));
    if (delta) updates_.finish(static_cast<size_t>(index), std::move(delta));
    return true;
  }

  std::map<std::string, std::string> parts() const {
    const auto part = [](std::initializer_list<std::pair<bool, const char*>> reasons) {
      for (const auto& [off, why] : reasons)
        if (off) return std::string("off: ") + why;
      return std::string("on");
    };
    bool glossy = false;
    for (const MeshShading& mesh : scene_.meshes)
      glossy |= mesh.kind != BsdfKind::kDiffuse && mesh.kind != BsdfKind::kDelta;
    const std::pair<bool, const char*> no_nee = {!settings_.nee, "not asked for"},
                                       no_lights = {lights_.empty(), "the scene has no lights"},
                                       no_guide = {!guide_, "the method has no guide"};
    return {
        {"nee", part({no_nee, no_lights})},
        {"light_table", part({{!settings_.nee, "nee is off"},
                              no_lights,
                              {!settings_.light_table, "not asked for"},
                              {lights_.picks_uniformly(), "all lights are equally strong"}})},
        {"russian_roulette",
         part({{!settings_.russian_roulette, "not asked for"},
               {settings_.max_depth <= kRouletteFromDepth, "paths end before it begins"}})},
        {"guide", part({no_guide})},
        {"mixing", part({no_guide, {!glossy, "all surfaces that are guided are diffuse"}})},
    };
  }

  RenderStats stats() const {
    RenderStats stats;
    stats.method = settings_.method;
    stats.unbiased = !guide_ || guide_->unbiased();
    stats.nee = settings_.nee;
    stats.parts = parts_;
    stats.seed = settings_.seed;
    stats.width = settings_.width;
    stats.height = settings_.height;
    stats.threads = pool_.threads();
    stats.seconds = elapsed();
    stats.prepare_seconds = scene_.seconds;
    stats.samples_per_pixel = done_;
    stats.learning_samples_per_pixel = learning_done_;
    stats.passes = plan_.passes();
    PathCounters sum;
    for (const Worker& worker : workers_) sum += worker.tracer.counters();
    stats.paths = sum.paths;
    stats.rays = sum.rays;
    stats.dropped_samples = sum.dropped_samples;
    if (guide_) {
      const GuideStats g = guide_->stats();
      stats.states = g.states;
      stats.table_bytes = g.bytes;
      stats.table_samples_seen = g.samples_seen;
      stats.table_refused = g.refused;
    }
    if (sum.timed_total > 0) {
      const double total = static_cast<double>(sum.timed_total);
      stats.share_tracing = static_cast<double>(sum.timed_tracing) / total;
      stats.share_guiding = static_cast<double>(sum.timed_guiding) / total;
      stats.share_rest = 1 - stats.share_tracing - stats.share_guiding;
    }
    return stats;
  }

  const PreparedScene& scene_;
  const RenderSettings& settings_;
  Guide* guide_;
  Film& film_;
  TaskPool& pool_;
  RenderObserver& observer_;
  std::stop_token stop_;
  const Clock& clock_;
  CameraRays camera_;
  PixelEstimate estimate_;
  LightPick uniform_lights_;
  const LightPick& lights_;
  const std::map<std::string, std::string> parts_;
  PassPlan plan_;
  OrderedUpdates updates_;
  std::vector<Worker> workers_;
  std::mutex observer_mutex_;
  double start_ = 0;
  bool learning_ = false;
  uint64_t done_ = 0, learning_done_ = 0;  // samples a pixel
};

}  // namespace

Result<RenderStats> render(const PreparedScene& scene, const RenderSettings& settings, Guide* guide,
                           Film& film, TaskPool& pool, RenderObserver& observer,
                           std::stop_token stop, const Clock& clock) {
  QRAY_CHECK(film.width() == settings.width && film.height() == settings.height);
  return Renderer(scene, settings, guide, film, pool, observer, std::move(stop), clock).run();
}

}  // namespace qray
