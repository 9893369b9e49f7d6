// The samples of a camera that rests: a job's renderer, stepped by as much as a frame has time for,
// takes those that a job of the same settings takes. They displace what earlier views showed. One
// thread calls; the pool's work.
#pragma once

#include "core/film/film.h"
#include "core/live/history.h"
#include "core/live/live_frame.h"
#include "core/render/renderer.h"

namespace qray {

// Of a pixel, from when on nothing that was seen before counts. Until then the number of samples
// that a pixel's mean claims never falls: kMostMovedSamples of earlier views leave as new ones
// come.
constexpr int kSamplesWithoutMoved = 64;
static_assert(kMostMovedSamples < kSamplesWithoutMoved);

class RestingPicture {
 public:
  // All outlive this. `guide` may be null. `view`: of the settings' size.
  RestingPicture(const PreparedScene& scene, const RenderSettings& settings, Guide* guide,
                 const ViewBuffer& view, TaskPool& pool, const Clock& clock);

  // Samples as much of one pass as `most_units` or the time until `end` allows; a frame ends with
  // its pass, so that what comes next knows the noise of what was. `may_learn`: of a pass that
  // starts now.
  void sample(size_t most_units, bool may_learn, const std::function<bool()>& enough,
              const std::stop_token& stop);

  const Renderer& renderer() const { return renderer_; }
  size_t tiles() const { return static_cast<size_t>(film_.tile_count()); }
  // The samples' mean.
  Image picture() const { return film_.develop(); }
  // Of each pixel, the samples and what is left of `moved`, which earlier views showed.
  History known(const History& moved) const;
  // Where lights show themselves, which known() leaves out: the samples' mean into `picture`.
  void put_lights(Image& picture) const;

 private:
  void keep(const TileSamples& samples);
  const RenderSettings settings_;
  const ViewBuffer& view_;
  History samples_;
  Film film_;
  Renderer renderer_;
};

}  // namespace qray
