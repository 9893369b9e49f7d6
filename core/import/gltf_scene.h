// glTF 2.0, .gltf and .glb: docs/gltf.md. Throws ImportFailure. Any thread.
#pragma once

#include <filesystem>
#include <optional>

#include "core/import/imported_scene.h"
#include "core/import/load_watch.h"
#include "core/scene/validate.h"

namespace qray {

// With a camera and with light: chosen to show it all where the file has none. As its animations
// have it after `seconds`; none: at rest.
ImportedScene read_gltf_scene(const std::filesystem::path& path, const SceneLimits& limits,
                              const LoadWatch& watch = {},
                              std::optional<double> seconds = std::nullopt);

}  // namespace qray
