// The gate between import and everything else: after validate() succeeds, indices are in range,
// numbers are finite and in range, and degenerate triangles are gone (counted).
#pragma once

#include "core/base/result.h"
#include "core/scene/scene.h"

namespace qray {

struct SceneLimits {
  size_t max_triangles = 5'000'000;  // an instanced mesh's count once
  size_t max_materials = 65'536;
  size_t max_lights = 65'536;        // without an extent
  size_t max_cameras = 1000;         // with names
  size_t max_instances = 1'000'000;  // half a KB each, once prepared
  int max_dimension_px = 8192;       // either side
  int64_t max_pixels = 4096LL * 4096;
};

struct ValidateReport {
  size_t dropped_triangles = 0;  // zero area
};

// Errors name the place as a pointer into the scene file: "/materials/3/ior",
// "/meshes/0/positions/7".
Result<ValidateReport> validate(Scene& scene, const SceneLimits& limits = {});

// pre: 0 < fov < 180, position != target, up not along the view, numbers finite. Errors name the
// place with that of the camera before it.
Status validate_camera(const Camera& camera, const std::string& place = "/camera");

}  // namespace qray
