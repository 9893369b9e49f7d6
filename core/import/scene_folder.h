// Files that a scene file names: relative, and in its folder or below. Who sends a scene must not
// learn what else this machine has: a name that leads out of the folder, be it only on its way, is
// not looked up, and is told in the same words as one that is missing. Any thread.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/base/result.h"

namespace qray {

// Of the scene file, canonical; links in the file's own name are not followed.
std::filesystem::path scene_folder(const std::filesystem::path& file);

// `name`, relative to `from`, canonical; none when it is not there or, links followed, not within
// `folder`. pre: `folder` is canonical, and so is `from`, within it.
std::optional<std::filesystem::path> follow_within(const std::filesystem::path& folder,
                                                   const std::filesystem::path& from,
                                                   const std::string& name);

// The same of a file. kNotFound, without a place.
Result<std::filesystem::path> find_within(const std::filesystem::path& folder,
                                          const std::filesystem::path& from,
                                          const std::string& name);

}  // namespace qray
