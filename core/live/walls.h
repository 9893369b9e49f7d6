// A camera that does not pass through what it sees. Pure functions.
#pragma once

#include "core/render/prepared_scene.h"

namespace qray {

// Where a camera comes to that wants to get from one place to another: it keeps a hundredth of the
// scene's radius away from surfaces, and slides along the first that is in its way. Glass is a
// surface too.
Vec3 stop_before_walls(const PreparedScene& scene, Vec3 from, Vec3 to);

}  // namespace qray
