// The figures of the thesis "AI and Machine Learning for Real-Time Ray Tracing", drawn again on a
// scene of ours: recovery of a quarter of the pixels, and guiding, with the published method and
// the corrected one beside it. The same options give the same picture for any number of threads.
#pragma once

#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>

#include "core/job/run_job.h"

namespace qray {

// 1: a quarter of the pixels. 2: views to train with. 3: a quarter, one sample each. 4: recovered
// from that. 5, 6: 8 and 64 samples a pixel without learning. 8: the states, a colour each. 10, 11
// (second view): 8 samples a pixel, left half without learning, right half with. 12, 13 (second
// view): 80 samples. Figure 9 needs no scene: core/render/direction_cube.h draws it.
struct ThesisFigure {
  int number = 0;
  // Of figures 10 to 13: huang-published (as printed, too bright), huang (corrected), or both, the
  // published one on the left.
  std::string method = "both";
  std::optional<std::pair<int, int>> size;  // pixels of one picture; none: the scene's
  uint64_t seed = 1;
  const Recovery* recovery = nullptr;  // of figure 4; null: the picture stays as it was sampled
};

// For whoever waits. Both are called on the threads that render.
struct ThesisWatch {
  RenderObserver& renders;
  std::function<void(int done, int all)> on_view;  // figure 2: how many of its views are done
};

// Linear picture. kInvalid names a setting out of range; kCanceled when stopped.
Result<Image> draw_thesis_figure(const PreparedScene& scene, const ThesisFigure& figure,
                                 TaskPool& pool, const ThesisWatch& watch, std::stop_token stop);

}  // namespace qray
