// A flight through a scene by several LiveViews, each with something switched off: their errors
// against long renders at the same places, and how their pictures flicker. Frames take their turns,
// so that all have the same machine; each view's flight goes on by the time that its frames take.
// One thread; the pool renders.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/job/run_job.h"
#include "core/laboratory/flight.h"
#include "core/live/live_view.h"

namespace qray {

struct LiveVariant {
  std::string name;
  LiveSwitches switches;
  bool forgets = false;  // all it saw, when the picture changes at once
  Pixels pixels = Pixels::kByNoise;
};
// full, no-learning, no-recovery, no-reprojection, plain, fresh, quarter, all.
std::vector<LiveVariant> live_variants();

struct FlightMeasures {
  std::string name;
  size_t frames = 0;
  double seconds = 0;
  LiveTimes times;             // sums over frames
  double paths = 0, rays = 0;  // the same
  double side = 0;             // LiveFrame::scale; the same
  std::vector<double> frame_seconds;
  std::map<double, double> relmse, trimmed;  // by the time of the reference
  // Of surface points over a second: variance of their luminance in time over (mean^2 + 0.01).
  double flicker = 0;
  size_t flicker_points = 0;

  double mean(const std::map<double, double>& errors) const;
};

struct FlightRun {
  std::shared_ptr<const PreparedScene> scene;
  Flight flight;
  LiveSettings settings;
  Network network;
  std::optional<TableFile> table;
  std::vector<LiveVariant> variants;
  std::map<double, Image> references;  // by time
  // Called with the picture at a reference's time, in full size.
  std::function<void(const std::string& variant, double seconds, const Image&)> on_picture;
};

Result<std::vector<FlightMeasures>> fly(const FlightRun& run, TaskPool& pool, std::stop_token stop);

}  // namespace qray
