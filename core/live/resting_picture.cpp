#include "core/live/resting_picture.h"

#include "core/base/check.h"

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
                               Guide* guide, const ViewBuffer& view, TaskPool& pool,
                               const Clock& clock)
    : settings_(resting_settings(settings)),
      view_(view),
      samples_(static_cast<size_t>(view.width) * static_cast<size_t>(view.height)),
      film_(settings.width, settings.height),
      renderer_(scene, settings_, guide, film_, pool, clock,
                {.most_pass_samples = 1,
                 .in_rounds = true,
                 .measures_noise = true,
                 .view_lasts = false,
                 .on_samples = [this](const TileSamples& samples) { keep(samples); }}) {
  QRAY_CHECK(view.width == settings.width && view.height == settings.height);
}

void RestingPicture::keep(const TileSamples& samples) {
  const TileRect& rect = samples.rect();
  for (int y = rect.y; y < rect.y + rect.height; ++y)
    for (int x = rect.x; x < rect.x + rect.width; ++x) {
      if (samples.count(x, y) == 0) continue;
      const size_t i = view_.index(x, y);
      if (!view_.shows_light(i)) samples_[i].add(samples.sum(x, y) / view_.albedo(i));
    }
}

History RestingPicture::known(const History& moved) const {
  History known = samples_;
  for (size_t i = 0; i < known.size(); ++i) {
    PixelHistory& k = known[i];
    PixelHistory before = moved[i];
    before.samples *= std::max(0.0f, 1 - k.samples / kSamplesWithoutMoved);
    if (before.samples == 0) continue;
    const float share = before.samples / (before.samples + k.samples);
    k = {lerp(share, k.light, before.light), lerp(share, k.square, before.square),
         k.samples + before.samples};
  }
  return known;
}

void RestingPicture::put_lights(Image& picture) const {
  const Image samples = film_.develop();
  for (int y = 0; y < view_.height; ++y)
    for (int x = 0; x < view_.width; ++x)
      if (view_.shows_light(view_.index(x, y))) picture.set_rgb(x, y, samples.rgb(x, y));
}

void RestingPicture::sample(size_t most_units, bool may_learn, const std::function<bool()>& enough,
                            const std::stop_token& stop) {
  if (!renderer_.in_pass()) renderer_.start_pass(may_learn);
  RenderObserver nobody;
  renderer_.sample(most_units, enough, stop, nobody);
  if (renderer_.units_left() == 0 && !stop.stop_requested()) renderer_.end_pass();
}

}  // namespace qray
