// What a render did, for stats.json, job records and image metadata. Plain data (proto/ includes
// it).
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace qray {

// What was known of the guide after a pass.
struct GuidePass {
  uint64_t samples = 0;  // a pixel, so far
  bool guided = false, learned = false;
  double share = 1;     // of the pixels, for which that was so
  double variance = 0;  // of a sample, as NoiseEstimate tells it; 0: not known
  // Variance x cost without the guide over the same with it; 0: not known.
  double efficiency_gain = 0;
  size_t states = 0, direction_nodes = 0, table_bytes = 0;
  template <class Self, class Archive>
  static void exchange(Self& self, Archive& archive) {
    archive(self.samples, self.guided, self.learned, self.share, self.variance,
            self.efficiency_gain, self.states, self.direction_nodes, self.table_bytes);
  }
};

struct RenderStats {
  std::string method;
  bool unbiased = true;
  bool nee = true;
  // What the renderer could do and whether it did: "on", or "off: " and why.
  std::map<std::string, std::string> parts;
  uint64_t seed = 0;
  int frames = 1;  // of a job of many: times and counts are all frames'
  int width = 0, height = 0, threads = 0;

  std::vector<std::string> light_groups;  // whose light was kept apart, by number
  std::string pixels = "all";             // which were sampled: all, quarter, by-noise
  std::string recovery = "none";          // by what the picture was made whole, if it was
  double recovery_seconds = 0;            // features counted
  double picture_passes_seconds = 0;      // of making them, once the picture was rendered
  // Pixels that the network guessed brighter or darker than all samples around, and held to these.
  uint64_t recovery_held_pixels = 0;

  double seconds = 0;          // of rendering; loading and recovery apart
  double prepare_seconds = 0;  // load, validate, build the tree
  uint64_t samples_per_pixel = 0;
  double noise = 0;                         // NoiseEstimate::level() at the end; 0: not known
  uint64_t learning_samples_per_pixel = 0;  // of these, how many there were when learning ended
  // Given back, these replay the job: the samples a pixel of each pass, how many tiles the last one
  // had when time was up (0: all, and samples_per_pixel counts it), and the samples of the pilot.
  std::vector<int> passes;
  int last_pass_tiles = 0;
  int pilot_samples = 0;  // the pilot's, of a pixel of its own; 0: there was none
  uint64_t paths = 0;
  uint64_t rays = 0;             // nearest-hit and occlusion queries
  uint64_t dropped_samples = 0;  // NaN or infinite, left out of the picture

  size_t states = 0;
  size_t table_bytes = 0;  // in memory
  uint64_t table_samples_seen = 0;
  std::vector<GuidePass> guide_passes;
  // Another build of qray rendered a part: not surely the bits of a run that was let alone.
  bool mixed_builds = false;
  uint64_t table_refused = 0;  // events not learned from: no room for their state

  // Shares of the threads' time, by timing one path in 64; they sum to 1 (0 when nothing ran).
  double share_tracing = 0, share_guiding = 0, share_rest = 0;

  double rays_per_second() const { return seconds > 0 ? static_cast<double>(rays) / seconds : 0; }
};

}  // namespace qray
