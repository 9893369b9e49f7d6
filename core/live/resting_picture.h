// The picture of a camera that rests: a job's renderer, stepped by as much as a frame has time for.
// Its samples are those that a job of the same settings takes. One thread calls; the pool's work.
#pragma once

#include "core/film/film.h"
#include "core/live/live_frame.h"
#include "core/render/renderer.h"

namespace qray {

class RestingPicture {
 public:
  // All outlive this. `guide` may be null. `on_samples`: Renderer's, may be empty.
  RestingPicture(const PreparedScene& scene, const RenderSettings& settings, Guide* guide,
                 TaskPool& pool, const Clock& clock,
                 std::function<void(const TileSamples&)> on_samples);

  double since() const { return since_; }  // the clock's seconds
  // Samples as much of one pass as `most_units` or the time until `end` allows; a frame ends with
  // its pass, so that what comes next knows the noise of what was. `may_learn`: of a pass that
  // starts now.
  void sample(size_t most_units, bool may_learn, const std::function<bool()>& enough,
              const std::stop_token& stop);

  const Renderer& renderer() const { return renderer_; }
  size_t tiles() const { return static_cast<size_t>(film_.tile_count()); }
  Image picture() const { return film_.develop(); }

 private:
  const RenderSettings settings_;
  const double since_;
  Film film_;
  Renderer renderer_;
};

}  // namespace qray
