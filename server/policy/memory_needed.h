// Whether a job or a live session learns, and the memory that it takes at most, as the budget
// counts it. Pure functions.
#pragma once

#include "core/settings/render_settings.h"

namespace qray::server {

inline bool learns(const RenderSettings& settings) {
  return settings.method != "none" && settings.learning_samples > 0;
}

inline size_t table_memory(const RenderSettings& settings) {
  return learns(settings) ? settings.max_table_bytes : 0;
}

// Bytes of the film, its noise and the table; of a network's work on the picture.
inline size_t job_memory(const RenderSettings& settings, bool recovers) {
  constexpr size_t kPixelBytes = 110, kRecoveryBytes = 160;
  const size_t pixels = static_cast<size_t>(settings.width) * static_cast<size_t>(settings.height);
  return pixels * (kPixelBytes + (recovers ? kRecoveryBytes : 0)) + table_memory(settings);
}

// Bytes of views, histories, film, recovery, pictures and the table.
inline size_t live_memory(const RenderSettings& settings) {
  constexpr size_t kPixelBytes = 600;
  const size_t pixels = static_cast<size_t>(settings.width) * static_cast<size_t>(settings.height);
  return pixels * kPixelBytes + table_memory(settings);
}

}  // namespace qray::server
