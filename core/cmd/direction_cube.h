// Figure 9 of the thesis: the 26 standard directions, from the middle of a 3 x 3 x 3 cube to the
// other 26 cubes. Drawn by a small line rasteriser. Any thread.
#pragma once

#include "core/image/image.h"

namespace qray::cmd {

// Linear picture on white; through a face red, an edge green, a corner blue.
Image draw_direction_cube(int width, int height);

}  // namespace qray::cmd
