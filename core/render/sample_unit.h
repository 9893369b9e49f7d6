// The samples of one unit of a pass: a tile's pixels of one round. The one place where a pass's
// pixels are sampled, for the renderer's own threads and for other processes (unit_renderer.h).
#pragma once

#include <span>
#include <stop_token>

#include "core/render/guided_pixels.h"
#include "core/render/pixel_plan.h"
#include "core/render/pixel_sampler.h"
#include "core/render/tile_samples.h"

namespace qray {

// What threads read of a pass while they sample it.
struct PassView {
  const CameraRays& camera;
  uint64_t seed;
  const PixelPlan& pixels;
  // Of a sample, standard, of each pixel of the plan's grid; empty: not known.
  std::span<const float> deviations;
  GuidedPixels guide;
};

// Into `samples`, which were started with the tile. `learn`: null, nothing is learned. False:
// stopped; the samples are of no use, and the tracer must discard() what waits.
bool sample_unit(const PassView& pass, int round, PathTracer& tracer, TileSamples& samples,
                 GuideDelta* learn, const std::stop_token& stop);

}  // namespace qray
