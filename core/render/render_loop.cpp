#include "core/render/render_loop.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <mutex>
#include <numeric>

#include "core/base/check.h"
#include "core/render/guide_gate.h"
#include "core/render/noise_estimate.h"
#include "core/render/ordered_updates.h"
#include "core/render/pass_plan.h"
#include "core/render/path.h"
#include "core/render/pixel_plan.h"

namespace qray {
namespace {

constexpr double kMaxFade = 16;
constexpr double kLookupNs = 110;  // of the guide, a vertex

// About, of one ray: measured from 36 triangles to 333,000 (design, section 4).
double ray_ns(const PreparedScene& scene) {
  const auto triangles = static_cast<double>(scene.scene.placed_triangle_count());
  return 75 + 17 * std::max(0.0, std::log2(triangles / 36));
}

// Alone in its cache lines, and in those that are fetched with them: threads write theirs all the
// time.
struct alignas(128) Worker {
  PathTracer tracer;
  std::vector<Rgb> sums;  // a pixel's samples of even and of odd number
  std::vector<uint32_t> counts;
};

class Renderer {
 public:
  Renderer(const PreparedScene& scene, const RenderSettings& settings, Guide* guide, Film& film,
           TaskPool& pool, RenderObserver& observer, std::stop_token stop, const Clock& clock,
           const Checkpoints& checkpoints)
      : scene_(scene),
        settings_(settings),
        guide_(guide),
        film_(film),
        pool_(pool),
        observer_(observer),
        stop_(std::move(stop)),
        clock_(clock),
        checkpoints_(checkpoints),
        camera_(settings.camera.value_or(scene.scene.camera), settings.width, settings.height),
        uniform_lights_(settings.light_table ? LightPick() : scene.lights.uniform()),
        lights_(settings.light_table ? scene.lights : uniform_lights_),
        parts_(parts()),
        plan_(settings),
        pixels_(settings),
        updates_(guide),
        gate_(kLookupNs / ray_ns(scene), guide && guide->stats().samples_seen > 0, !settings.gate) {
    if (guide || settings.estimates_noise || settings.noise > 0 ||
        settings.pixels == Pixels::kAdaptive)
      noise_.emplace(pixels_.width(), pixels_.height());
    for (int i = 0; i < pool.threads(); ++i)
      workers_.push_back({{scene, lights_, settings, guide}, {}, {}});
  }

  Result<RenderStats> run() {
    start_ = clock_.seconds();
    if (checkpoints_.resume_from && !resume(*checkpoints_.resume_from))
      return Error{ErrorCode::kCorrupt, "not a state of this render", "checkpoint"};
    for (;;) {
      if (!in_pass_ && !start_pass()) break;
      if (!render_pass()) return Error{ErrorCode::kCanceled, "canceled", ""};
      in_pass_ = false;
      done_ += static_cast<uint64_t>(pass_samples_);
      pixels_.end_pass();
      if (learning_) {
        guide_->end_pass();
        learning_done_ += static_cast<uint64_t>(pass_samples_);
      }
      if (guide_) {
        judge_pass();
      } else if (noise_) {
        noise_->end_pass();
      }
      if (noise_) noise_level_ = noise_->level();
      if (settings_.estimates_noise) film_.set_noise(noise_picture());
      last_pass_seconds_ = elapsed() - pass_start_;
      observer_.on_pass(progress(0), stats(), guide_);
    }
    if (checkpoints_.keeper) (void)save();  // so that more can be added to it some day
    return stats();
  }

 private:
  double elapsed() const { return clock_.seconds() - start_; }
  RenderAge age() const { return {done_, elapsed(), noise_level_}; }

  RenderProgress progress(double in_pass) const {
    const RenderAge now = age();
    return {learning_, plan_.fraction(now, in_pass), done_, now.seconds, now.noise};
  }

  PathCounters counters() const {
    PathCounters sum = counters_before_;
    for (const Worker& worker : workers_) sum += worker.tracer.counters();
    return sum;
  }
  PassCost cost_so_far() const {
    const PathCounters sum = counters();
    return {static_cast<double>(sum.paths), static_cast<double>(sum.rays),
            static_cast<double>(sum.lookups)};
  }

  // Whether the guide pays, and what the picture so far counts against what comes: passes weigh as
  // much as their noise, which is known when a pass is over, so each by that of the pass before.
  void judge_pass() {
    const PassCost before = cost_;
    cost_ = cost_so_far();
    const PassCost pass{cost_.paths - before.paths, cost_.rays - before.rays,
                        cost_.lookups - before.lookups};
    if (!guided_) gate_.unguided_pass(pass);
    GuidePass record{done_, guided_, learning_, 0, 0, 0, 0, 0};
    if (noise_->end_pass()) {
      record.variance = noise_->variance();
      const double variance_before = noise_->variance_before();
      if (guide_->expects() && changing_ && variance_before > 0 && record.variance > 0)
        film_.fade(static_cast<float>(
            std::clamp(record.variance / variance_before, 1 / kMaxFade, kMaxFade)));
      changing_ = false;
      if (guided_ && guide_->expects() && gate_.on())
        record.gain = gate_.guided_pass(done_, pass, record.variance, noise_->unguided_variance());
      if (!gate_.grows()) guide_->stop_growing();
    }
    const GuideStats table = guide_->stats();
    record.states = table.states;
    record.direction_nodes = table.direction_nodes;
    record.table_bytes = table.bytes;
    guide_passes_.push_back(record);
    if (!gate_.on()) parts_["guide"] = "off: it cost more than it saved";
  }

  // False: there is none.
  bool start_pass() {
    pass_samples_ = plan_.next(age(), last_pass_seconds_);
    if (pass_samples_ == 0) return false;
    in_pass_ = true;
    next_tile_ = 0;
    pass_start_ = elapsed();
    learning_ = guide_ && gate_.learns() && plan_.learning(age());
    plan_.started(pass_samples_);
    const bool guided =
        guide_ && (!guide_->expects() || gate_.guides(done_, guide_->stats().samples_seen));
    changing_ |= (guided && learning_) || guided != guided_;  // the noise that follows is another
    guided_ = guided;
    if (noise_) noise_->start_pass(guided_);
    pixels_.start_pass(pass_samples_, noise_ ? &*noise_ : nullptr);
    return true;
  }

  // What is left of the pass. False when stopped.
  bool render_pass() {
    for (Worker& worker : workers_)
      worker.tracer.set_guiding(guided_     ? PathTracer::Guiding::kOn
                                : learning_ ? PathTracer::Guiding::kWatch
                                            : PathTracer::Guiding::kOff);
    updates_.start_pass(next_tile_);
    const size_t tiles = static_cast<size_t>(film_.tile_count());
    size_t finished = next_tile_;
    const auto body = [&](size_t i, int worker) {
      if (!render_tile(static_cast<int>(next_tile_ + i), workers_[static_cast<size_t>(worker)],
                       pass_samples_))
        return;
      std::lock_guard lock(observer_mutex_);
      ++finished;
      observer_.on_tile(
          progress(pass_samples_ * static_cast<double>(finished) / static_cast<double>(tiles)));
    };
    const auto enough = [&] { return checkpoints_.keeper && checkpoints_.keeper->due(); };
    while (next_tile_ < tiles) {
      const size_t done = pool_.run_until(tiles - next_tile_, body, enough);
      if (stop_.stop_requested()) return false;
      next_tile_ += done;
      if (enough() && !save()) return false;
    }
    return true;
  }

  template <class Self, class Archive>
  static void exchange(Self& self, Archive& archive) {
    archive(self.plan_, self.pixels_, self.gate_, self.cost_, self.guided_, self.changing_,
            self.guide_passes_, self.learning_, self.done_, self.learning_done_, self.in_pass_,
            self.pass_samples_, self.next_tile_, self.noise_level_, self.parts_);
  }

  // False: the render shall end.
  bool save() {
    return checkpoints_.keeper->save([this](SnapshotWriter& out) {
      const double now = elapsed();
      out(settings_.method, static_cast<int>(settings_.pixels), settings_.seed, now,
          now - pass_start_, last_pass_seconds_, counters());
      exchange(*this, out);
      if (noise_) out(*noise_);
      film_.save_state(out);
      if (guide_) guide_->save_state(out);
    });
  }

  bool resume(SnapshotReader& in) {
    std::string method;
    int pixels = 0;
    uint64_t seed = 0;
    double elapsed_before = 0, in_pass = 0;
    in(method, pixels, seed, elapsed_before, in_pass, last_pass_seconds_, counters_before_);
    if (method != settings_.method || pixels != static_cast<int>(settings_.pixels) ||
        seed != settings_.seed)
      return false;
    start_ -= elapsed_before;
    pass_start_ = elapsed_before - in_pass;
    exchange(*this, in);
    if (noise_) in(*noise_);
    film_.load_state(in);
    if (guide_) guide_->load_state(in);
    if (!in.whole()) return false;
    if (settings_.estimates_noise && done_ > 0) film_.set_noise(noise_picture());
    return true;
  }

  // False when stopped; the tile is then left out of the film.
  bool render_tile(int index, Worker& worker, int samples) {
    const TileRect rect = film_.tile(index);
    const size_t pixels = static_cast<size_t>(rect.width) * static_cast<size_t>(rect.height);
    worker.sums.assign(2 * pixels, Rgb{});
    worker.counts.assign(pixels, 0);
    std::unique_ptr<GuideDelta> delta = learning_ ? updates_.empty_delta() : nullptr;
    Sampler sampler(settings_.seed);
    const int step = pixels_.step();
    const auto in_tile = [&](int x, int y) {
      return static_cast<size_t>(y - rect.y) * static_cast<size_t>(rect.width) +
             static_cast<size_t>(x - rect.x);
    };
    for (int y = rect.y; y < rect.y + rect.height; y += step) {
      for (int x = rect.x; x < rect.x + rect.width; x += step) {
        if (stop_.stop_requested()) {
          worker.tracer.discard();
          return false;
        }
        const int gx = x / step, gy = y / step;
        const size_t pixel = in_tile(x, y);
        const uint32_t first = pixels_.first(gx, gy), count = pixels_.count(gx, gy);
        worker.counts[pixel] = count;
        for (uint32_t s = first; s < first + count; ++s) {
          sampler.start(static_cast<uint32_t>(x), static_cast<uint32_t>(y), s);
          const Vec2 in_pixel = sampler.next_2d();
          const Vec2 lens = camera_.has_lens() ? sampler.next_2d() : Vec2{};
          const Ray ray = camera_.ray(
              {static_cast<float>(x) + in_pixel.x, static_cast<float>(y) + in_pixel.y}, lens);
          worker.tracer.sample(ray, sampler, delta.get(), noise_ ? noise_->deviation(gx, gy) : 0.0f,
                               worker.sums[pixel * 2 + (s & 1)]);
        }
      }
    }
    worker.tracer.flush();
    for (int y = rect.y; y < rect.y + rect.height; ++y) {
      for (int x = rect.x; x < rect.x + rect.width; ++x) {
        const size_t pixel = in_tile(x, y);
        const Rgb even = worker.sums[pixel * 2], odd = worker.sums[pixel * 2 + 1];
        worker.sums[pixel] = even + odd;
        if (noise_ && x % step == 0 && y % step == 0)
          noise_->add(x / step, y / step, pixels_.first(x / step, y / step), worker.counts[pixel],
                      luminance(even), luminance(odd));
      }
    }
    worker.sums.resize(pixels);
    film_.add(index, worker.sums, static_cast<uint32_t>(samples), worker.counts);
    if (delta) updates_.finish(static_cast<size_t>(index), std::move(delta));
    return true;
  }

  Image noise_picture() const {
    const int step = pixels_.step();
    Image picture(settings_.width, settings_.height, kFilmNoiseChannels);
    for (int y = 0; y < pixels_.height(); ++y)
      for (int x = 0; x < pixels_.width(); ++x) {
        const auto set = [&](FilmNoise channel, float value) {
          picture.at(x * step, y * step, channel) = value;
        };
        set(kRelativeError, noise_->relative_error(x, y));
        set(kOwnError, noise_->own_error(x, y));
        set(kDeviation, noise_->deviation(x, y));
        set(kSamples, noise_->samples(x, y));
      }
    return picture;
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
    stats.unbiased = (!guide_ || guide_->unbiased()) && settings_.pixels != Pixels::kAdaptive;
    stats.nee = settings_.nee;
    stats.pixels = pixels_name(settings_.pixels);
    stats.parts = parts_;
    stats.seed = settings_.seed;
    stats.width = settings_.width;
    stats.height = settings_.height;
    stats.threads = pool_.threads();
    stats.seconds = elapsed();
    stats.prepare_seconds = scene_.seconds;
    stats.samples_per_pixel = done_;
    stats.noise = noise_level_;
    stats.learning_samples_per_pixel = learning_done_;
    stats.passes = plan_.passes();
    const PathCounters sum = counters();
    stats.paths = sum.paths;
    stats.rays = sum.rays;
    stats.dropped_samples = sum.dropped_samples;
    stats.guide_passes = guide_passes_;
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
  const Checkpoints checkpoints_;
  CameraRays camera_;
  LightPick uniform_lights_;
  const LightPick& lights_;
  std::map<std::string, std::string> parts_;
  PassPlan plan_;
  PixelPlan pixels_;
  OrderedUpdates updates_;
  std::vector<Worker> workers_;
  std::optional<NoiseEstimate> noise_;
  GuideGate gate_;
  PassCost cost_;
  bool guided_ = false;    // the last pass was
  bool changing_ = false;  // the guide, since noise was last known
  std::vector<GuidePass> guide_passes_;
  std::mutex observer_mutex_;
  double start_ = 0;
  bool learning_ = false;
  uint64_t done_ = 0, learning_done_ = 0;  // samples a pixel
  // The pass that is under way: its samples a pixel, the first tile that is not done.
  bool in_pass_ = false;
  int pass_samples_ = 0;
  size_t next_tile_ = 0;
  double pass_start_ = 0, last_pass_seconds_ = 0;
  double noise_level_ = 0;        // NoiseEstimate::level() after the last pass
  PathCounters counters_before_;  // of the renders that this one goes on from
};

}  // namespace

Result<RenderStats> render(const PreparedScene& scene, const RenderSettings& settings, Guide* guide,
                           Film& film, TaskPool& pool, RenderObserver& observer,
                           std::stop_token stop, const Clock& clock,
                           const Checkpoints& checkpoints) {
  QRAY_CHECK(film.width() == settings.width && film.height() == settings.height);
  return Renderer(scene, settings, guide, film, pool, observer, std::move(stop), clock, checkpoints)
      .run();
}

}  // namespace qray
