// A camera's way through a scene: keys at times, a smooth curve through them (Catmull and Rom).
// docs/live.md is the format. Any thread.
#pragma once

#include <filesystem>
#include <vector>

#include "core/base/result.h"
#include "core/scene/camera.h"

namespace qray {

struct FlightKey {
  double seconds = 0;
  Camera camera;
  bool cut = false;           // the camera is here at once; no curve leads to it
  std::vector<float> lights;  // factors from here on; empty: as before
};

struct Flight {
  std::vector<FlightKey> keys;  // at least one, times rising from 0

  double seconds() const { return keys.back().seconds; }
  Camera at(double seconds) const;  // before the first key and after the last: as there
  // Factors of the lights at that time; empty: as the scene has them.
  std::vector<float> lights_at(double seconds) const;
  // When pictures change at once: cuts, and lights switched.
  std::vector<double> events() const;
};

// Every camera begins as `camera`, of which a key may change what it names.
Result<Flight> load_flight(const std::filesystem::path& path, const Camera& camera);

}  // namespace qray
