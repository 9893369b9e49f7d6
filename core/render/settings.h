// What to render of a scene. Plain data; checked by check_settings().
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/guide/guide.h"
#include "core/scene/camera.h"

namespace qray {

constexpr int kMaxSamples = 1'000'000;  // a pixel

struct RenderSettings {
  std::string method = "adaptive";
  bool nee = true;
  bool russian_roulette = true;
  bool light_table = true;  // lights are picked by their power; else all alike
  bool gate = true;  // a guide that does not pay is left (guide_gate.h); else it rules regardless
  int width = 512, height = 512;  // pixels
  int samples = 64;    // a pixel, counting learning samples; with `seconds`: at most, 0 = no limit
  double seconds = 0;  // > 0: stop when no further pass fits. The first pass always completes
  uint64_t seed = 1;
  int max_depth = 16;                  // surfaces on a path
  std::optional<Camera> camera;        // none: the scene's
  int learning_samples = kMaxSamples;  // a pixel, the guide's at most; never over 1/4 of the job
  size_t max_table_bytes = kDefaultTableBytes;  // of memory; a full table adds no states
  HuangParams huang;
  AdaptiveParams adaptive;
  std::vector<int> passes;  // replay: samples of each pass; overrides samples and seconds
};

// Errors name the field as a pointer: "/samples".
Status check_settings(const RenderSettings& settings, int64_t max_pixels);

}  // namespace qray
