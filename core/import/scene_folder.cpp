#include "core/import/scene_folder.h"

#include <algorithm>

namespace qray {

std::filesystem::path scene_folder(const std::filesystem::path& file) {
  const std::filesystem::path folder = std::filesystem::absolute(file).parent_path();
  std::error_code ec;
  std::filesystem::path canonical = std::filesystem::canonical(folder, ec);
  return ec ? folder : canonical;
}

bool is_within(const std::filesystem::path& path, const std::filesystem::path& folder) {
  const auto [end, ignored] = std::mismatch(folder.begin(), folder.end(), path.begin(), path.end());
  return end == folder.end();
}

Result<std::filesystem::path> find_within(const std::filesystem::path& folder,
                                          const std::filesystem::path& from,
                                          const std::string& name) {
  std::error_code ec;
  std::filesystem::path path = std::filesystem::canonical(from / name, ec);
  if (ec || !std::filesystem::is_regular_file(path, ec))
    return Error{ErrorCode::kNotFound, "no such file: \"" + name + "\"", ""};
  if (!is_within(path, folder))
    return Error{ErrorCode::kInvalid, "\"" + name + "\" lies outside the scene's folder", ""};
  return path;
}

}  // namespace qray
