// What each thread of a render has for itself, and the lights as the settings want them picked.
// A worker is used by one thread at a time; everything else between passes, by one thread.
#pragma once

#include <vector>

#include "core/render/path.h"
#include "core/render/tile_samples.h"

namespace qray {

// Alone in its cache lines, and in those that are fetched with them: threads write theirs all the
// time.
struct alignas(128) RenderWorker {
  PathTracer tracer;
  TileSamples samples;
};

class RenderWorkers {
 public:
  // All outlive this; `guide` may be null, and so may `split`: light is not told apart.
  RenderWorkers(const PreparedScene& scene, const RenderSettings& settings, const Guide* guide,
                TaskPool& pool, const LightSplit* split = nullptr)
      : uniform_lights_(settings.light_table ? LightPick() : scene.lights.uniform()),
        lights_(settings.light_table ? scene.lights : uniform_lights_) {
    const bool aims = guide && guide->aims_at_caustics() && settings.adaptive.caustics;
    const CausticMap* caustics = aims ? scene.caustics(pool) : nullptr;
    for (int i = 0; i < pool.threads(); ++i)
      workers_.push_back({{scene, lights_, settings, guide, split, caustics}, {}});
  }
  RenderWorkers(const RenderWorkers&) = delete;
  RenderWorkers& operator=(const RenderWorkers&) = delete;

  RenderWorker& operator[](int worker) { return workers_[static_cast<size_t>(worker)]; }
  int threads() const { return static_cast<int>(workers_.size()); }
  const LightPick& lights() const { return lights_; }

  // Whether paths ask the guide for directions, and whether it learns from them.
  void set_guiding(bool guided, bool learning) {
    for (RenderWorker& worker : workers_) worker.tracer.set_guiding(guided, learning);
  }
  void hide_lights_seen_directly() {
    for (RenderWorker& worker : workers_) worker.tracer.hide_lights_seen_directly();
  }
  PathCounters counters() const {
    PathCounters sum;
    for (const RenderWorker& worker : workers_) sum += worker.tracer.counters();
    return sum;
  }

 private:
  const LightPick uniform_lights_;
  const LightPick& lights_;
  std::vector<RenderWorker> workers_;
};

}  // namespace qray
