// What a user may call a scene: a name in the scenes folder ("cornell-box"), a folder with a
// scene.json in it, or a file. Any thread.
#pragma once

#include <filesystem>
#include <string_view>

#include "core/base/result.h"

namespace qray {

// [a-z0-9-]+, the only names that may come over HTTP: never a path.
bool is_scene_name(std::string_view name);

// A file or folder as given goes before a name.
Result<std::filesystem::path> resolve_scene_path(std::string_view name_or_path,
                                                 const std::filesystem::path& scenes_dir);

// By name alone; for requests from outside.
Result<std::filesystem::path> resolve_scene_name(std::string_view name,
                                                 const std::filesystem::path& scenes_dir);

}  // namespace qray
