// Where what a ray met stands at another time of the scene. Any thread.
#pragma once

#include <optional>

#include "core/render/prepared_scene.h"

namespace qray {

// From the hit's point p to where the same point of the surface is in `other`, the same file's
// scene at another time, metres; exactly 0 where it has not moved. None: `other` has no such
// surface.
std::optional<Vec3> surface_motion(const PreparedScene& scene, const Hit& hit, Vec3 p,
                                   const PreparedScene& other);

}  // namespace qray
