// Made-up rooms for recovery to learn from, beside real ones: each has walls of some pattern,
// things of matt, shiny, mirroring or clear materials (boxes, balls, vessels, tables, shelves of
// books, rails as thin as a pixel), and light from panels, from many small lamps, from a lamp
// behind a screen or beyond a gap, or from a sky with a sun, from above or through a window.
#pragma once

#include <cstdint>

#include "core/scene/scene.h"

namespace qray {

// The same seed makes the same room. It passes validate().
Scene generated_scene(uint64_t seed);

}  // namespace qray
