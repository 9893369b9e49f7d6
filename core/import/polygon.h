// A polygon of a file as triangles. Any thread.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/math/vec.h"

namespace qray {

// Of 3 or more corners; the triangles count in them and wind as they do. Four are cut along the
// shorter diagonal, more by ear clipping (Meisters 1975), so that concave ones keep their shape.
// One that crosses itself gives triangles too.
std::vector<std::array<uint32_t, 3>> cut_polygon(std::span<const Vec3> corners);

}  // namespace qray
