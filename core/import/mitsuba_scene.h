// Mitsuba scenes, versions 0.5, 0.6, 2 and 3: docs/mitsuba.md says what is read and how. Throws
// ImportFailure. Any thread.
#pragma once

#include "core/import/json_scene.h"

namespace qray {

JsonScene read_mitsuba_scene(const std::filesystem::path& path, const SceneLimits& limits,
                             const LoadWatch& watch = {});

}  // namespace qray
