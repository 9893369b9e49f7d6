// The thesis' 26 standard directions (section 4.3, Figure 9): from the centre of a 3 x 3 x 3 cube
// to its other cells; and how much of a hemisphere is nearest to each. Any thread.
#pragma once

#include <array>

#include "core/math/vec.h"

namespace qray {

constexpr int kDirections26 = 26;

// Unit vectors in the order of (x, y, z) from -1 to 1, z fastest, the centre left out.
const std::array<Vec3, kDirections26>& directions26();

// Index of the standard direction nearest to the unit vector d.
int nearest_direction26(Vec3 d);

// The fraction of the hemisphere about the unit normal n that is nearest to each direction: areas
// of spherical polygons, exact but for rounding; they sum to 1.
std::array<float, kDirections26> hemisphere_shares26(Vec3 n);

}  // namespace qray
