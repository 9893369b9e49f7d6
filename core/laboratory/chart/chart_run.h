// One run of a chart: a job with a time budget whose picture is looked at while it forms, with the
// clock stopped. One thread; the pool renders.
#pragma once

#include <stop_token>

#include "core/base/task_pool.h"
#include "core/image/image.h"
#include "core/laboratory/chart/results.h"
#include "core/render/render_loop.h"

namespace qray {

struct ChartPlan {
  std::vector<std::string> scenes;   // as the chart calls them
  std::vector<std::string> methods;  // variants, see variant.h
  std::vector<uint64_t> seeds;
  double seconds = 60;        // of rendering, a run
  int width = 0, height = 0;  // 0: each scene's own
  bool warm = false;          // a second series for methods that keep tables
  float warm_turn_deg = 0;    // of the camera of the job that leaves the table, see turned()
};

struct ChartRun {
  std::string scene;   // as the chart calls it
  std::string method;  // a variant
  bool warm = false;
  uint64_t seed = 0;
  bool operator==(const ChartRun&) const = default;
};

// All runs on the scenes that `plan` names, in their order: by scene, then by seed, so that what
// drifts on a machine touches all methods alike. Each seed begins with the next method; cold goes
// before warm.
std::vector<ChartRun> chart_runs(const ChartPlan& plan);

// A run's times: from seconds/256, growing by sqrt 2, each below `seconds`. A row is made at the
// first end of a pass at or after each; its `point` is the index of the last one that has passed.
// The run's final picture has the index after all of them.
std::vector<double> chart_times(double seconds);

// About its position and its up axis, to the left; degrees.
Camera turned(const Camera& camera, float degrees);

// Picture size, depth and budget for a scene.
RenderSettings chart_settings(const Scene& scene, const ChartPlan& plan);

struct ChartRunResult {
  std::vector<ChartRow> rows;  // by time; the last one is the final picture's
  Image picture;
};

// A warm run first lets another job of the same length, with other random numbers, leave its table;
// that job's time is not counted. `clock` runs on while pictures are compared; rows do not.
// `observer` may be slow between passes: that is not counted either.
Result<ChartRunResult> measure_run(const PreparedScene& scene, const ChartPlan& plan,
                                   const ChartRun& run, const Image& reference, TaskPool& pool,
                                   RenderObserver& observer, std::stop_token stop,
                                   const Clock& clock);

}  // namespace qray
