// Made-up rooms for recovery to learn from, beside real ones: each has walls of some pattern,
// furniture of matt, shiny, mirroring or clear materials, rails as thin as a pixel, and light from
// panels, from many small lamps, from a lamp behind a screen, or from a sky with a sun.
#pragma once

#include <cstdint>

#include "core/scene/scene.h"

namespace qray {

// The same seed makes the same room. It passes validate().
Scene generated_scene(uint64_t seed);

}  // namespace qray
