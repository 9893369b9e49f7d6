#include "core/render/sample_unit.h"

namespace qray {

bool sample_unit(const PassView& pass, int round, PathTracer& tracer, TileSamples& samples,
                 GuideDelta* learn, const std::stop_token& stop) {
  const PixelPlan& pixels = pass.pixels;
  PixelSampler sampler(pass.camera, pass.seed, tracer);
  const bool whole = pixels.for_each_in_round(round, samples.rect(), [&](int x, int y) {
    if (stop.stop_requested()) return false;
    const int column = x / pixels.step(), row = y / pixels.step();
    const uint32_t first = pixels.first(column, row), count = pixels.count(column, row);
    const float deviation =
        pass.deviations.empty() ? 0.0f : pass.deviations[pixels.index(column, row)];
    samples.set_count(x, y, count);
    const bool learned = learn && pass.guide.learns(column, row);
    tracer.set_guiding(pass.guide.guided && pass.guide.serves(column, row), learned);
    for (uint32_t number = first; number < first + count; ++number)
      sampler.sample(x, y, number, learned ? learn : nullptr, deviation,
                     samples.target(x, y, first, count, number));
    return true;
  });
  if (whole) tracer.flush();
  return whole;
}

}  // namespace qray
