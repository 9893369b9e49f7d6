// Mitsuba scenes, versions 0.5, 0.6, 2 and 3: docs/mitsuba.md says what is read and how. Throws
// ImportFailure. Any thread.
#pragma once

#include "core/import/imported_scene.h"
#include "core/import/load_watch.h"
#include "core/scene/validate.h"

namespace qray {

ImportedScene read_mitsuba_scene(const std::filesystem::path& path, const SceneLimits& limits,
                                 const LoadWatch& watch = {});

}  // namespace qray
