#include "core/laboratory/live_flight.h"

#include <algorithm>
#include <deque>
#include <numeric>

#include "core/image/metrics.h"
#include "core/live/lights.h"

namespace qray {
namespace {

constexpr double kFlickerSeconds = 1;
constexpr int kFlickerStepPx = 4, kMarginPx = 2;
constexpr size_t kLeastSeen = 5;  // frames that show a point

// What a view showed within the last second.
struct Shown {
  double seconds;
  ViewBuffer view;
  std::vector<float> luminance;
};

// One variant's flight.
struct Flyer {
  LiveVariant variant;
  std::unique_ptr<LiveView> view;
  FlightMeasures measures;
  double now = 0, window_began = 0;
  std::vector<float> lights;
  std::deque<Shown> window;
  bool ended = false;
};

// Whether a pixel and those around it show one surface: its true value stays as the camera moves.
bool within_surface(const ViewBuffer& view, int x, int y) {
  for (int dy = -kMarginPx; dy <= kMarginPx; ++dy)
    for (int dx = -kMarginPx; dx <= kMarginPx; ++dx) {
      const int i = x + dx, j = y + dy;
      if (i < 0 || j < 0 || i >= view.width || j >= view.height ||
          !view.same_surface(view.index(i, j), view.index(x, y)))
        return false;
    }
  return true;
}

std::optional<float> seen_at(const Shown& shown, const ViewBuffer& from, size_t point) {
  const std::optional<Vec2> at = shown.view.camera.project(from.points[point]);
  if (!at) return {};
  const int x = static_cast<int>(std::floor(at->x)), y = static_cast<int>(std::floor(at->y));
  if (x < 0 || y < 0 || x >= shown.view.width || y >= shown.view.height) return {};
  const size_t i = shown.view.index(x, y);
  const float distance = shown.view.camera.distance(from.points[point]);
  if (shown.view.surfaces[i] != from.surfaces[point] ||
      dot(shown.view.normal(i), from.normal(point)) < ViewBuffer::kLeastCosine ||
      std::abs(dot(from.normal(point), shown.view.points[i] - from.points[point])) >
          2 * shown.view.camera.cone().at(distance) ||
      !within_surface(shown.view, x, y))
    return {};
  return shown.luminance[i];
}

// Points of surfaces that look the same from everywhere, as long as they are in sight.
void measure_flicker(Flyer& flyer) {
  if (flyer.window.size() < kLeastSeen) return;
  const ViewBuffer& from = flyer.window.front().view;
  for (int y = 0; y < from.height; y += kFlickerStepPx)
    for (int x = 0; x < from.width; x += kFlickerStepPx) {
      const size_t point = from.index(x, y);
      if (from.kind(point) != 0 || !within_surface(from, x, y)) continue;
      double sum = 0, squares = 0, seen = 0;
      for (const Shown& shown : flyer.window)
        if (const std::optional<float> v = seen_at(shown, from, point)) {
          const double value = static_cast<double>(*v);
          sum += value, squares += value * value, seen += 1;
        }
      if (seen < static_cast<double>(kLeastSeen)) continue;
      const double mean = sum / seen;
      flyer.measures.flicker +=
          (squares / seen - mean * mean) * seen / (seen - 1) / (mean * mean + 0.01);
      ++flyer.measures.flicker_points;
    }
}

// The next of `times` in (after, until]; `until` if there is none.
double snapped(const std::map<double, Image>& times, double after, double until) {
  const auto next = times.upper_bound(after);
  return next != times.end() && next->first <= until ? next->first : until;
}

class FlightRunner {
 public:
  FlightRunner(const FlightRun& run, TaskPool& pool, std::stop_token stop)
      : run_(run), pool_(pool), stop_(std::move(stop)) {}

  Result<std::vector<FlightMeasures>> fly() {
    std::vector<Flyer> flyers;
    for (const LiveVariant& variant : run_.variants) {
      flyers.push_back({variant, nullptr, {}, 0, 0, {}, {}, false});
      flyers.back().measures.name = variant.name;
      if (Status s = start(flyers.back()); !s.ok()) return s.error();
    }
    for (;;) {
      const auto next =
          std::min_element(flyers.begin(), flyers.end(), [](const Flyer& a, const Flyer& b) {
            return std::pair(a.ended, a.now) < std::pair(b.ended, b.now);
          });
      if (next->ended) break;
      if (Status s = frame(*next); !s.ok()) return s.error();
    }
    std::vector<FlightMeasures> all;
    for (Flyer& flyer : flyers) {
      if (flyer.measures.flicker_points > 0)
        flyer.measures.flicker /= static_cast<double>(flyer.measures.flicker_points);
      all.push_back(std::move(flyer.measures));
    }
    return all;
  }

 private:
  Status start(Flyer& flyer) {
    Result<std::unique_ptr<Guide>> guide =
        load_guide(*run_.scene, run_.settings.render, run_.table);
    if (!guide.ok()) return guide.error();
    LiveSettings settings = run_.settings;
    settings.render.pixels = flyer.variant.pixels;
    flyer.view = std::make_unique<LiveView>(run_.scene, settings, std::move(guide).value(),
                                            run_.network, pool_, clock_);
    flyer.view->set_switches(flyer.variant.switches);
    return {};
  }

  // What happened between two frames.
  Status change(Flyer& flyer, double before, double now) {
    for (const double event : run_.flight.events()) {
      if (!(event > before && event <= now)) continue;
      flyer.window.clear();
      if (flyer.variant.forgets) flyer.view->set_scene(scene_of(flyer));
    }
    const std::vector<float> lights = run_.flight.lights_at(now);
    if (lights == flyer.lights) return {};
    flyer.lights = lights;
    auto& scene = scenes_[lights];
    if (!scene) {
      Result<std::shared_ptr<const PreparedScene>> changed = with_lights(run_.scene, lights);
      if (!changed.ok()) return changed.error();
      scene = changed.value();
    }
    flyer.view->set_scene(scene);
    return {};
  }
  std::shared_ptr<const PreparedScene> scene_of(const Flyer& flyer) {
    return flyer.lights.empty() ? run_.scene : scenes_[flyer.lights];
  }

  Status frame(Flyer& flyer) {
    FlightMeasures& m = flyer.measures;
    const double before = m.frames == 0 ? -1 : flyer.now;
    const double last = m.frames == 0 ? 0 : m.frame_seconds.back();
    const double now = snapped(run_.references, before, flyer.now + last);
    if (Status s = change(flyer, before, now); !s.ok()) return s;
    flyer.view->set_camera(run_.flight.at(now));
    std::optional<LiveFrame> frame = flyer.view->next_frame(stop_);
    if (!frame) return Error{ErrorCode::kCanceled, "canceled", ""};
    flyer.now = now;
    ++m.frames;
    m.frame_seconds.push_back(frame->times.whole);
    m.seconds += frame->times.whole;
    for (auto part : {&LiveTimes::features, &LiveTimes::reprojection, &LiveTimes::samples,
                      &LiveTimes::learning, &LiveTimes::recovery, &LiveTimes::whole})
      m.times.*part += frame->times.*part;
    m.paths += static_cast<double>(frame->paths);
    m.rays += static_cast<double>(frame->rays);
    m.side += frame->scale;
    show(flyer, frame->picture);
    flyer.ended = now >= run_.flight.seconds();
    if (flyer.ended) measure_flicker(flyer);
    return {};
  }

  void show(Flyer& flyer, const Image& full) {
    const int width = run_.settings.render.width, height = run_.settings.render.height;
    if (const auto reference = run_.references.find(flyer.now);
        reference != run_.references.end()) {
      const Result<ImageDifference> d = image_difference(full, reference->second);
      if (d.ok()) {
        flyer.measures.relmse[flyer.now] = d.value().relmse;
        flyer.measures.trimmed[flyer.now] = d.value().relmse_trimmed;
      }
      if (run_.on_picture) run_.on_picture(flyer.variant.name, flyer.now, full);
    }
    if (flyer.window.empty()) flyer.window_began = flyer.now;
    flyer.window.push_back(
        {flyer.now, see_view(*run_.scene, run_.flight.at(flyer.now), width, height, pool_), {}});
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        flyer.window.back().luminance.push_back(luminance(full.rgb(x, y)));
    if (flyer.now - flyer.window_began >= kFlickerSeconds) {
      measure_flicker(flyer);
      flyer.window.clear();
    }
  }

  const FlightRun& run_;
  TaskPool& pool_;
  std::stop_token stop_;
  SteadyClock clock_;
  std::map<std::vector<float>, std::shared_ptr<const PreparedScene>> scenes_;
};

}  // namespace

std::vector<LiveVariant> live_variants() {
  return {{"full", {}},
          {"no-learning", {.learning = false}},
          {"no-recovery", {.recovery = false}},
          {"no-reprojection", {.reprojection = false}},
          {"plain", {false, false, false}},
          {"fresh", {}, true},
          {"quarter", {}, false, Pixels::kQuarter},
          {"all", {}, false, Pixels::kAll}};
}

double FlightMeasures::mean(const std::map<double, double>& errors) const {
  double sum = 0;
  for (const auto& [seconds, error] : errors) sum += error;
  return errors.empty() ? 0 : sum / static_cast<double>(errors.size());
}

Result<std::vector<FlightMeasures>> fly(const FlightRun& run, TaskPool& pool,
                                        std::stop_token stop) {
  return FlightRunner(run, pool, std::move(stop)).fly();
}

}  // namespace qray
