// Files that a scene file names: they must lie in its folder or below. Any thread.
#pragma once

#include <filesystem>
#include <string>

#include "core/base/result.h"

namespace qray {

// Of the scene file, canonical; links in the file's own name are not followed.
std::filesystem::path scene_folder(const std::filesystem::path& file);

// Both canonical.
bool is_within(const std::filesystem::path& path, const std::filesystem::path& folder);

// The file `name`, relative to `from`, canonical. An error, without a place, when it is not there
// or, links followed, not within `folder`. pre: `folder` is canonical, `from` within it.
Result<std::filesystem::path> find_within(const std::filesystem::path& folder,
                                          const std::filesystem::path& from,
                                          const std::string& name);

}  // namespace qray
