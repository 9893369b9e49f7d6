#include "core/live/resting_picture.h"

namespace qray {
namespace {

// All pixels alike, without an end.
RenderSettings resting_settings(RenderSettings settings) {
  settings.pixels = Pixels::kAll;
  settings.samples = 0;
  settings.seconds = 0;
  settings.noise = 0;
  settings.passes.clear();
  return settings;
}

}  // namespace

RestingPicture::RestingPicture(const PreparedScene& scene, const RenderSettings& settings,
                               Guide* guide, TaskPool& pool, const Clock& clock,
                               std::function<void(const TileSamples&)> on_samples)
    : settings_(resting_settings(settings)),
      since_(clock.seconds()),
      film_(settings.width, settings.height),
      renderer_(scene, settings_, guide, film_, pool, clock,
                {.most_pass_samples = 1,
                 .in_rounds = true,
                 .measures_noise = true,
                 .view_lasts = false,
                 .on_samples = std::move(on_samples)}) {}

void RestingPicture::sample(size_t most_units, bool may_learn, const std::function<bool()>& enough,
                            const std::stop_token& stop) {
  if (!renderer_.in_pass()) renderer_.start_pass(may_learn);
  RenderObserver nobody;
  renderer_.sample(most_units, enough, stop, nobody);
  if (renderer_.units_left() == 0 && !stop.stop_requested()) renderer_.end_pass();
}

}  // namespace qray
