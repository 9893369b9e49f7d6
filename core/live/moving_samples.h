// The samples of a camera that moves: few a frame, shared out over blocks of 2 x 2 pixels, added to
// the pixels' history. One thread calls; the pool's work.
#pragma once

#include <vector>

#include "core/live/history.h"
#include "core/live/live_frame.h"
#include "core/live/live_picture.h"
#include "core/render/guided_pixels.h"
#include "core/render/ordered_updates.h"
#include "core/render/render_workers.h"

namespace qray {

class MovingSamples {
 public:
  // All outlive this; `guide` may be null.
  MovingSamples(const RenderSettings& settings, Guide* guide, const Clock& clock)
      : settings_(settings), guide_(guide), updates_(guide, clock) {}

  // What a frame's samples are taken of and added to. `blocks`: of the frame before, null where
  // there is none of this size.
  struct Frame {
    const ViewBuffer& view;
    History& history;
    const BlockGrid* blocks;
    uint64_t number;
    double paths_per_block;  // that all can afford on average
    GuidedPixels guide;      // of tiles in place of pixels
  };
  // What the guide learns rules sampling from the next frame on.
  void sample(const Frame& frame, RenderWorkers& workers, TaskPool& pool,
              const std::stop_token& stop);
  double update_seconds() const { return updates_.seconds(); }  // of one thread, so far
  void size_changed(size_t pixels) { next_sample_.assign(pixels, 0); }

 private:
  double more_for_few() const;  // samples of a block of which little is known, over others'
  double per_block(const Frame& frame) const;
  std::vector<size_t> choose_pixels(const Frame& frame, int tile, double per_block) const;
  void choose_in_block(const Frame& frame, size_t first, double per_block,
                       std::vector<size_t>& chosen) const;
  void sample_tile(const Frame& frame, int tile, double per_block, PathTracer& tracer,
                   GuideDelta* learn);

  const RenderSettings& settings_;
  Guide* guide_;
  OrderedUpdates updates_;
  std::vector<uint32_t> next_sample_;  // by pixel of the view
};

}  // namespace qray
