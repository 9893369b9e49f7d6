// Whether a job or a live session learns, and the memory that it takes at most, as the budget
// counts it. Pure functions.
#pragma once

#include "core/film/film.h"
#include "core/settings/render_settings.h"

namespace qray::server {

inline bool learns(const RenderSettings& settings) {
  return settings.method != "none" && settings.learning_samples > 0;
}

inline size_t table_memory(const RenderSettings& settings) {
  return learns(settings) ? settings.max_table_bytes : 0;
}

// Bytes of a pixel: of the film's layers while the job renders; of the passes and their file once
// it ends.
inline size_t passes_pixel_bytes(const RenderSettings& settings, const FilmLayers& layers) {
  constexpr size_t kLayerBytes = 12, kChannelBytes = 2 * sizeof(float);  // in memory and encoded
  size_t channels = settings.makes_passes() ? 3 : 0;                     // the picture's own
  for (size_t pass = 0; pass < kPicturePassNames.size(); ++pass)
    if (settings.picture_passes.has(static_cast<PicturePass>(pass)))
      channels += pass_channels(static_cast<PicturePass>(pass));
  channels += 3 * static_cast<size_t>(layers.groups);
  return kLayerBytes * static_cast<size_t>(layers.count()) + kChannelBytes * channels;
}

// Bytes of the film, its noise, its layers and the table; of a network's work on the picture.
inline size_t job_memory(const RenderSettings& settings, bool recovers, const FilmLayers& layers) {
  constexpr size_t kPixelBytes = 110, kRecoveryBytes = 160;
  const size_t pixels = static_cast<size_t>(settings.width) * static_cast<size_t>(settings.height);
  return pixels * (kPixelBytes + (recovers ? kRecoveryBytes : 0) +
                   passes_pixel_bytes(settings, layers)) +
         table_memory(settings);
}

// Bytes of the scene as a frame shows it, beside the scene at rest, of `scene_bytes`; of the frames
// beside it where motion is told.
inline size_t moved_memory(const RenderSettings& settings, size_t scene_bytes) {
  return scene_bytes * (settings.picture_passes.has(PicturePass::kMotion) ? 3 : 1);
}

// Bytes of views, histories, film, recovery, pictures and the table.
inline size_t live_memory(const RenderSettings& settings) {
  constexpr size_t kPixelBytes = 600;
  const size_t pixels = static_cast<size_t>(settings.width) * static_cast<size_t>(settings.height);
  return pixels * kPixelBytes + table_memory(settings);
}

}  // namespace qray::server
