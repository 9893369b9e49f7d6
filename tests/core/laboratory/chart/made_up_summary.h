// A summary with lines like those of real methods, for what draws one.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/laboratory/chart/results.h"

namespace qray::test {

// Errors fall like 1/seconds down to the floor, or to a bias that stays.
inline MethodSummary made_up_method(const std::string& name, double error_at_1s, double floor,
                                    double bias = 0) {
  MethodSummary method;
  method.method = name;
  method.seeds = 5;
  for (double seconds = 0.5; seconds < 70; seconds *= std::sqrt(2)) {
    ChartPoint point;
    point.seconds = seconds;
    point.samples_per_pixel = std::floor(40 * seconds);
    const double error = error_at_1s / seconds + bias * bias;
    point.at_floor = error <= floor;
    point.relmse = std::max(error, floor);
    point.low = std::max(error * 0.8, floor);
    point.high = std::max(error * 1.4, floor);
    point.relmse_trimmed = point.relmse * 0.6;
    point.flip = std::sqrt(point.relmse) * 0.3;
    method.points.push_back(point);
  }
  method.efficiency = {0.05 / error_at_1s, 0.04 / error_at_1s, 0.06 / error_at_1s};
  method.efficiency_trimmed = {0.04 / error_at_1s, 0.03 / error_at_1s, 0.05 / error_at_1s};
  method.time_to_equal_error = error_at_1s / 0.05;
  method.slope = -1 + bias;
  method.brightness = 1 + bias;
  method.bias_z = bias * 500;
  method.unbiased = bias == 0;
  method.biased = bias != 0;
  return method;
}

inline SceneSummary made_up_scene(const std::string& name, double floor) {
  SceneSummary scene;
  scene.reference.scene = name;
  scene.reference.scene_hash = "9f86d081884c7d65";
  scene.reference.width = scene.reference.height = 64;
  scene.reference.method = "huang";
  scene.reference.samples_per_pixel = 16384;
  scene.reference.seconds = 600;
  scene.reference.floor_relmse = floor;
  scene.methods = {made_up_method("none", 0.05, floor),
                   made_up_method("huang-published", 0.03, floor, 0.8),
                   made_up_method("huang", 0.01, floor)};
  return scene;
}

inline ChartSummary made_up_summary() {
  ChartSummary summary;
  summary.command = "qray chart made-up";
  summary.commit = "0123456";
  summary.machine = "a machine, 2 processors";
  summary.date = "2024-01-31";
  summary.threads = 2;
  summary.seconds = 60;
  summary.seeds = {1, 2, 3, 4, 5};
  summary.scenes = {made_up_scene("ajar-door", 2e-4)};
  return summary;
}

}  // namespace qray::test
