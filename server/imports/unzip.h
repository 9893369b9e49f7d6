// Zip archives that nobody vouches for, through libzip. One thread.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/result.h"

namespace qray::server {

struct Unzipped {
  std::vector<std::string> names;  // of files
  uint64_t bytes = 0;
};

// Into `folder`, which is empty. Names are those that FileNames takes, of files and folders, never
// links; what is unpacked is counted as it comes, whatever the archive says of its sizes. Errors
// name the file in the archive. What was unpacked before an error stays.
Result<Unzipped> unzip(const std::filesystem::path& archive, const std::filesystem::path& folder,
                       uint64_t max_bytes);

}  // namespace qray::server
