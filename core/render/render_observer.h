// Who is told how far a render is.
#pragma once

#include "core/guide/guide.h"
#include "core/render/stats.h"

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

}  // namespace qray
