// Files to a zip archive that holds them as they are, under their names. Any thread.
#pragma once

#include <filesystem>
#include <vector>

#include "core/base/result.h"

namespace qray::server {

// `path` must not be there yet. kIo: there is no room.
Status zip_files(const std::filesystem::path& path,
                 const std::vector<std::filesystem::path>& files);

}  // namespace qray::server
