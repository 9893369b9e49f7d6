// Whether a folder's entries may have changed since they were last read: other servers may use it.
// One thread at a time.
#pragma once

#include <chrono>
#include <filesystem>

namespace qray::server {

class FolderWatch {
 public:
  // True, and the entries are to be read now. The folder's time may be coarse, so a change of the
  // last moments is taken for one that was not seen.
  bool changed(const std::filesystem::path& folder) {
    std::error_code ec;
    const auto at = std::filesystem::last_write_time(folder, ec);
    if (ec || (at == seen_ && settled_)) return false;
    seen_ = at;
    settled_ = std::filesystem::file_time_type::clock::now() - at > std::chrono::seconds(2);
    return true;
  }

 private:
  std::filesystem::file_time_type seen_{};
  bool settled_ = false;
};

// Last written so long ago, or longer.
inline bool is_older(const std::filesystem::path& path, std::chrono::seconds age) {
  std::error_code ec;
  const auto at = std::filesystem::last_write_time(path, ec);
  return age <= std::chrono::seconds(0) ||
         (!ec && std::filesystem::file_time_type::clock::now() - at >= age);
}

}  // namespace qray::server
