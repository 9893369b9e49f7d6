// What to render of a scene. Plain data; checked by check_settings().
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/guide/guide.h"
#include "core/scene/camera.h"
#include "core/settings/picture_passes.h"

namespace qray {

constexpr int kMaxSamples = 1'000'000;  // a pixel

// Which pixels are sampled: all; the first of each block of 2 x 2 (the thesis' Figure 1); or those,
// from the time on when their noise is known, more or less by it.
enum class Pixels { kAll, kQuarter, kByNoise };
std::string_view pixels_name(Pixels pixels);  // all, quarter, by-noise
std::optional<Pixels> pixels_named(std::string_view name);

struct PixelRegion {
  int x = 0, y = 0, width = 0, height = 0;  // pixels, from the top left
  bool empty() const { return width == 0 && height == 0 && x == 0 && y == 0; }
};

struct RenderSettings {
  std::string method = "adaptive";
  bool nee = true;
  bool russian_roulette = true;
  bool light_table = true;  // lights are picked by their power; else all alike
  bool gate = true;  // a guide that does not pay is left (guide_gate.h); else it rules regardless
  int width = 512, height = 512;  // pixels
  Pixels pixels = Pixels::kAll;   // others than kAll: width and height must be even
  PixelRegion region;             // it gets its samples first (pixel_plan.h); empty: none does
  std::string recover = "none";   // what makes the picture whole: a name, that only charts look up
                                  // (run_job is given its network)
  bool estimates_noise = false;   // for Film::noise(); some methods and pixels do anyway
  int samples =
      64;  // a sampled pixel, counting learning samples; with `seconds`: at most, 0 = no limit
  double seconds = 0;  // > 0: stop then. The first pass always completes
  double noise = 0;  // > 0: stop when the picture's relative error (NoiseEstimate::level()) is that
                     // low; samples or seconds bound it
  uint64_t seed = 1;
  int max_depth = 16;            // surfaces on a path
  std::optional<Camera> camera;  // none: the scene's
  PicturePasses picture_passes;  // beside the picture
  LightGrouping light_groups = LightGrouping::kNone;
  std::string mix;  // of the groups' light (light_mix.h): the scene is lit so; empty: as it is
  int learning_samples = kMaxSamples;  // a pixel, the guide's at most; never over half of the job
  size_t max_table_bytes = kDefaultTableBytes;  // of memory; a full table adds no states
  HuangParams huang;
  AdaptiveParams adaptive;
  std::vector<int> passes;  // replay: samples of each pass; overrides samples and seconds
  int last_pass_tiles = 0;  // replay: of the last one, the first so many alone; 0: all
  int pilot_samples = 0;    // replay: the pilot's, of a pixel of its own; 0: as many as it needs

  // Whether pixels get samples by their noise. Not where a region comes first.
  bool counts_by_noise() const {
    const bool wanted = method == "adaptive" && adaptive.by_noise && pixels == Pixels::kAll;
    return pixels == Pixels::kByNoise || (wanted && region.empty());
  }
  int bounce_layers() const { return qray::bounce_layers(picture_passes, max_depth); }
  bool makes_passes() const {
    return !picture_passes.empty() || light_groups != LightGrouping::kNone;
  }
};

// Against the ranges of the table of fields (job_fields.h). Errors name the field as a pointer:
// "/samples", "/guide/alpha".
Status check_settings(const RenderSettings& settings, int64_t max_pixels);

}  // namespace qray
