// Renders a prepared scene: passes over all pixels, tiles over a thread pool, the guide updated
// between passes. The same settings and table give the same bits for any number of threads.
#pragma once

#include <stop_token>

#include "core/base/clock.h"
#include "core/base/task_pool.h"
#include "core/film/film.h"
#include "core/render/checkpoint.h"
#include "core/render/prepared_scene.h"
#include "core/render/stats.h"
#include "core/settings/render_settings.h"

namespace qray {

struct RenderProgress {
  bool learning = false;
  double fraction = 0;             // of the job, by samples or by time, [0, 1]
  uint64_t samples_per_pixel = 0;  // in complete passes
  double seconds = 0;
  double noise = 0;  // the picture's relative error, as estimated; 0: not known
};

// Called by worker threads, one at a time; must return soon.
class RenderObserver {
 public:
  virtual ~RenderObserver() = default;
  virtual void on_tile(const RenderProgress&) {}
  // Between passes, on the thread that renders: what it does meanwhile holds the job up. The guide
  // is null for method none.
  virtual void on_pass(const RenderProgress&, const RenderStats& /*so_far*/, const Guide*) {}
};

// `guide` may be null (method none). Stops within 100 ms of a request with kCanceled; the film then
// holds what was finished. kCorrupt: what it should go on from is of another render; film and guide
// are then of no more use. It may go on to more samples, or seconds, than it was begun with.
Result<RenderStats> render(const PreparedScene& scene, const RenderSettings& settings, Guide* guide,
                           Film& film, TaskPool& pool, RenderObserver& observer,
                           std::stop_token stop, const Clock& clock,
                           const Checkpoints& checkpoints = {});

}  // namespace qray
