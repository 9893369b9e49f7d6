// What a live session's calls carry, as plain std types (docs/api.md, openapi.yaml). Any thread;
// nothing here throws on bad input.
#pragma once

#include "core/settings/job_settings.h"
#include "proto/messages.h"

namespace qray::proto {

struct LiveSwitchesRequest {
  bool learning = true, recovery = true, reprojection = true;
};

// By live_fields(), with their defaults.
struct LiveRequest {
  std::string scene;
  std::optional<int> width, height;  // pixels, even; absent: the scene's own
  double frame_ms = 100;
  std::string method = "adaptive", table = "auto", recover = "auto";  // as JobRequest's
  std::string pixels = "by-noise";  // of a camera that moves: all, quarter, by-noise
  uint64_t seed = 1;
  std::optional<int> max_depth;
  std::optional<CameraRequest> camera;
  LiveSwitchesRequest switches;
};

struct LiveCameraRequest {
  uint64_t number = 0;  // the latest wins
  CameraRequest camera;
  bool walls = false;  // stop it
};
// What became of it.
struct LiveCameraAnswer {
  uint64_t number = 0;              // of the newest camera known
  std::optional<Vector3> position;  // where a wall stopped it
};

struct LiveInfo {
  std::string id, scene, method, pixels;
  std::string recover, table_in;  // recover: what serves; table_in: empty, none
  int width = 0, height = 0;
  double frame_ms = 0;
  uint64_t camera_number = 0;
  CameraRequest camera;  // complete
  LiveSwitchesRequest switches;
  std::vector<std::string> lights;
  std::vector<double> factors;  // of the lights
  std::string mix;              // the same for a job; empty: it has too many groups
  std::vector<std::pair<std::string, CameraRequest>> cameras;  // of the scene, complete
  uint64_t frames = 0;
  int readers = 0;
};

// Problems as for parse_job_request().
std::variant<LiveRequest, Problem> parse_live_request(std::string_view json,
                                                      const RequestLimits& limits);
std::variant<LiveCameraRequest, Problem> parse_live_camera(std::string_view json,
                                                           const RequestLimits& limits);
// Members that are absent stay as `now` has them.
std::variant<LiveSwitchesRequest, Problem> parse_live_switches(std::string_view json,
                                                               const RequestLimits& limits,
                                                               const LiveSwitchesRequest& now);
// {"factors":[1, 0]}: one for each of `lights` lights.
std::variant<std::vector<double>, Problem> parse_live_lights(std::string_view json,
                                                             const RequestLimits& limits,
                                                             size_t lights);
std::string live_to_json(const LiveInfo& live);
std::string live_camera_to_json(const LiveCameraAnswer& answer);

}  // namespace qray::proto
