// A render as an object that is stepped: passes over all pixels, tiles over a thread pool, the
// guide updated between passes. Who drives it decides when it pauses, is kept and is shown:
// render() for jobs, core/live for a camera at rest. The same settings and table give the same bits
// for any number of threads and however it is stepped. One thread calls; the pool's work.
#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <stop_token>

#include "core/base/clock.h"
#include "core/base/task_pool.h"
#include "core/film/film.h"
#include "core/render/guide_decision.h"
#include "core/render/noise_estimate.h"
#include "core/render/ordered_updates.h"
#include "core/render/pass_plan.h"
#include "core/render/pilot.h"
#include "core/render/pixel_plan.h"
#include "core/render/render_observer.h"
#include "core/render/render_workers.h"
#include "core/render/sample_unit.h"

namespace qray {

// By what a picture that someone watches differs from a job's. The default is a job.
struct RenderMode {
  int most_pass_samples = PassPlan::kMostSamples;  // a pixel
  bool in_rounds = false;       // parts of a pass cover the picture evenly (pixel_plan.h)
  bool measures_noise = false;  // whether or not the settings need it
  bool view_lasts = true;       // guide_decision.h
  // Hears of the samples of each unit, on the worker's thread; may be empty.
  std::function<void(const TileSamples&)> on_samples;
};

class Renderer {
 public:
  // All outlive this; the film is of the settings' size, and has the layers that light_split()
  // says. `guide` may be null (method none).
  Renderer(const PreparedScene& scene, const RenderSettings& settings, Guide* guide, Film& film,
           TaskPool& pool, const Clock& clock, RenderMode mode = {});

  // Before the first pass: what this render's pilot found and cost counts as its own.
  void begin_after(const Pilot& pilot);

  // False: the plan has no further pass, the render is done. `may_learn` false: not from this pass,
  // whatever the plan says.
  bool start_pass(bool may_learn = true);
  bool in_pass() const { return pass_.running; }
  // Samples units of the pass, a tile's round each, in their order: at most `most`, until
  // `enough()` (asked before each by the workers, one at a time). Returns how many were sampled.
  // Stopped, it has lost some: then this is only good for what the film holds.
  size_t sample(size_t most, const std::function<bool()>& enough, const std::stop_token& stop,
                RenderObserver& observer);
  size_t units() const;  // of a whole pass
  size_t units_left() const { return pass_units() - pass_.next_unit; }
  // The settings' time is up. That ends a pass as it is: the picture has what was sampled of it,
  // and a render that goes on from this one's state samples the rest.
  bool out_of_time() const { return !learning() && plan_.out_of_time(age()); }
  bool pass_whole() const { return pass_.next_unit == units(); }

  // Where units of the pass are sampled by other processes (unit_renderer.h): what they need of it
  // beside scene and settings, and of the guide where needs_guide() says so. Not in rounds, and of
  // a guide that has copies. The guide stays the same through a pass, and while it learns nothing.
  bool needs_guide() const { return guided() || learning(); }
  void save_pass(SnapshotWriter& out) const;
  void save_guide(SnapshotWriter& out) const;
  int pass() const { return static_cast<int>(plan_.passes().size()); }  // its number, from 1 on
  size_t next_unit() const { return pass_.next_unit; }  // of the pass, the first not sampled
  double samples_a_unit() const {                       // paths, on average
    return static_cast<double>(pixels_.pixels()) * pass_.samples / static_cast<double>(units());
  }
  // The next units, as UnitRenderer::sample() gave them. False: these are not they, and nothing was
  // added.
  bool add_units(std::span<const uint8_t> sampled, RenderObserver& observer);

  // Once it is whole.
  void end_pass();

  RenderProgress progress(double samples_in_pass = 0) const;
  RenderStats stats() const;
  // A pixel, on average; of the pass under way what was sampled.
  double samples_per_pixel() const;
  PathCounters counters() const;
  bool guided() const { return decision_ && decision_->guided(); }  // the last pass that started
  const GuideDecision* decision() const { return decision_ ? &*decision_ : nullptr; }  // or null
  // That the guide took so far: of the threads' time while they sample, and between passes.
  double learning_seconds() const;

  // Everything but the guide, between units: the film too. load_state() into a fresh renderer;
  // false: what it reads is of another render, and the film is of no more use. A render may go on
  // to more samples, or seconds, than it was begun with.
  void save_state(SnapshotWriter& out) const;
  bool load_state(SnapshotReader& in);

 private:
  struct Pass {
    bool running = false;
    int samples = 0;       // a pixel
    size_t next_unit = 0;  // the first that is not sampled
    double start = 0;      // seconds of the render
  };
  size_t pass_units() const;
  bool shows_noise() const;
  bool learning() const { return decision_ && decision_->learning(); }
  double elapsed() const { return clock_.seconds() - start_; }
  RenderAge age() const { return {samples_, elapsed(), noise_level_}; }
  PassView pass_view() const;
  bool sample_one(size_t unit, RenderWorker& worker, const std::stop_token& stop);
  void add_samples(size_t unit, TileSamples& samples);
  void add_noise(int round, const TileSamples& samples);
  void measure_pass();
  Image noise_picture() const;

  template <class Self, class Archive>
  static void exchange(Self& self, Archive& archive) {
    archive(self.plan_, self.pixels_, self.measures_, self.pass_.running, self.pass_.samples,
            self.pass_.next_unit, self.samples_, self.learning_samples_, self.noise_level_,
            self.last_pass_seconds_, self.pilot_samples_);
  }

  const PreparedScene& scene_;
  const RenderSettings& settings_;
  Guide* guide_;
  Film& film_;
  TaskPool& pool_;
  const Clock& clock_;
  const RenderMode mode_;
  const CameraRays camera_;
  const LightSplit split_;
  double start_;  // before what the workers prepare
  RenderWorkers workers_;
  const std::map<std::string, std::string> parts_;

  PassPlan plan_;
  PixelPlan pixels_;
  std::optional<NoiseEstimate> noise_;
  std::optional<GuideDecision> decision_;
  OrderedUpdates updates_;

  Pass pass_;
  bool measures_ = false;  // the noise of the pass
  // A pixel, in complete passes; and at the end of the last one that the guide learned from.
  uint64_t samples_ = 0, learning_samples_ = 0;
  double noise_level_ = 0;  // NoiseEstimate::level() after the last pass
  double last_pass_seconds_ = 0, guide_pass_seconds_ = 0;
  int pilot_samples_ = 0;         // a pixel of its own
  PathCounters counters_before_;  // of the renders that this one goes on from
  std::mutex observer_mutex_;
};

}  // namespace qray
