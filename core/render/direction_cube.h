// Figure 9 of the thesis: the 26 standard directions, from the middle of a 3 x 3 x 3 cube to the
// other 26 cubes, seen from the front (+z), the right (+x) and above (+y). Drawn by a small line
// rasteriser. Any thread.
#pragma once

#include <array>

#include "core/guide/directions26.h"
#include "core/image/image.h"

namespace qray {

// Linear picture on white; through a face red, an edge green, a corner blue.
Image draw_direction_cube(int width, int height);
// Linear picture on black; colours in the order of directions26().
Image draw_direction_cube(int width, int height, const std::array<Rgb, kDirections26>& colors);

}  // namespace qray
