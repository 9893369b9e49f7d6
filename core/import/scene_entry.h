// Which of several files is the scene. Pure functions.
#pragma once

#include <span>
#include <string>

#include "core/base/result.h"

namespace qray {

// Of the files nearest to the top that may be scenes: scene.json, else the only .gltf or .glb, else
// the only .xml, .obj, .ply. kNotFound, or kInvalid naming several.
Result<std::string> find_scene_entry(std::span<const std::string> names);

}  // namespace qray
