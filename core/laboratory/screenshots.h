// Pictures that the renderer takes by itself of a scene, for recovery to learn from (the thesis'
// Figure 2). The same scene, settings and seed give the same views for any number of threads.
#pragma once

#include <functional>

#include "core/guide/table_file.h"
#include "core/recover/training_view.h"
#include "core/render/render_loop.h"

namespace qray {

constexpr int kScreenshotSide = 128;  // pixels

struct ScreenshotOptions {
  int views = 40;
  int inputs = 1;           // of each view, in other random numbers and of other counts of samples
  int least_samples = 1;    // a pixel of the input; twice as many in each next one, in turn
  int most_samples = 64;    // until there
  int target_samples = 64;  // a pixel, in two halves, whose distance tells the target's own error
  bool guided_targets = false;  // rendered by 'adaptive', which learns from view to view
  uint64_t seed = 1;
};

// Cameras at random places within the scene's bounds that see what the scene's own camera might:
// none of 64 directions hits within 2 % of the scene's size, and the view is no bare wall. Each is
// the one of up to 24 in which most changes from place to place. Each
// shows kScreenshotSide pixels of a picture of any height up to `most_height`, small ones as often
// as twice as large ones. Fewer where the scene has no such places.
std::vector<Camera> screenshot_cameras(const PreparedScene& scene, int count, int most_height,
                                       uint64_t seed);

// Rendered by the settings' method, which draws from `table` if there is one and learns nothing.
// The inputs of a view, each with its features and target, stand side by side.
// kInvalid where the scene has no places to look from; kCanceled when stopped. `on_view`: after
// each, how many are done.
Result<std::vector<TrainingView>> take_screenshots(const PreparedScene& scene,
                                                   RenderSettings settings,
                                                   const std::optional<TableFile>& table,
                                                   const ScreenshotOptions& options, TaskPool& pool,
                                                   std::stop_token stop, const Clock& clock,
                                                   const std::function<void(int)>& on_view);

}  // namespace qray
