#include "core/render/pilot.h"

#include <algorithm>
#include <cmath>

#include "core/math/hash.h"
#include "core/render/renderer.h"

namespace qray {
namespace {

// Of a pilot: fewer do not tell noise that few paths make. A picture has at least kLeastPictures
// times as many.
constexpr double kLeastPixels = 4096, kMostPixels = 16384, kLeastPictures = 4;
// Of a job's seconds: a longer pilot costs a short job more than its guide brings.
constexpr double kMostTime = 0.1;
constexpr uint64_t kSeed = 0x70696c6f74;  // its samples are not the picture's

// None: the picture is too small.
std::optional<RenderSettings> pilot_settings(const RenderSettings& settings) {
  const double pixels = static_cast<double>(settings.width) * settings.height;
  const double sampled = settings.pixels == Pixels::kQuarter ? pixels / 4 : pixels;
  if (sampled < kLeastPictures * kLeastPixels) return {};
  const double wanted = std::clamp(sampled / GuideGate::kPart, kLeastPixels, kMostPixels);
  const double scale = std::sqrt(wanted / pixels);
  RenderSettings pilot = settings;
  pilot.width = std::max(1, static_cast<int>(std::lround(scale * settings.width)));
  pilot.height = std::max(1, static_cast<int>(std::lround(scale * settings.height)));
  pilot.pixels = Pixels::kAll;
  pilot.estimates_noise = false;
  pilot.seconds = pilot.noise = 0;
  pilot.samples = 2 * GuideGate::kMostPilotSamples;  // it learns from half
  pilot.learning_samples = kMaxSamples;              // a replay names the picture's alone
  pilot.passes.clear();
  pilot.picture_passes = {};
  pilot.seed = mix64(settings.seed ^ kSeed);
  return pilot;
}

}  // namespace

std::optional<Pilot> render_pilot(const PreparedScene& scene, const RenderSettings& settings,
                                  Guide* guide, TaskPool& pool, const Clock& clock,
                                  const std::stop_token& stop) {
  if (!guide || !guide->expects() || !settings.gate || settings.learning_samples == 0) return {};
  if (GuideGate::paid(guide->worth())) return {};
  const std::optional<RenderSettings> small = pilot_settings(settings);
  if (!small) return {};

  Film film(small->width, small->height, film_layers(scene.scene, *small));
  RenderObserver nobody;
  RenderMode mode;
  mode.in_rounds = true;       // there are few tiles for the threads
  mode.measures_noise = true;  // also where the guide waits
  mode.view_lasts = false;     // the picture's own passes tell whether the table need grow
  Renderer renderer(scene, *small, guide, film, pool, clock, mode);
  const GuideGate& gate = renderer.decision()->gate();
  const double most_seconds = kMostTime * settings.seconds, start = clock.seconds();
  uint64_t samples = 0;
  const auto over = [&] {
    if (settings.pilot_samples > 0) return samples >= static_cast<uint64_t>(settings.pilot_samples);
    return gate.pilot_is_over(samples, guide->stats().samples_seen) ||
           (most_seconds > 0 && gate.knows_noise(samples) &&
            clock.seconds() - start > most_seconds);
  };
  while (!over() && renderer.start_pass()) {
    renderer.sample(
        renderer.units(), [] { return false; }, stop, nobody);
    if (stop.stop_requested()) return {};
    renderer.end_pass();
    samples = renderer.progress().samples_per_pixel;
  }
  return Pilot{gate.after_pilot(), renderer.counters(), static_cast<int>(samples)};
}

}  // namespace qray
