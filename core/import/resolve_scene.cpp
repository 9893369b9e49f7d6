#include "core/import/resolve_scene.h"

#include <algorithm>

namespace qray {
namespace fs = std::filesystem;

bool is_scene_name(std::string_view name) {
  constexpr size_t kMaxLength = 64;
  return !name.empty() && name.size() <= kMaxLength &&
         std::all_of(name.begin(), name.end(), [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
         });
}

Result<fs::path> resolve_scene_name(std::string_view name, const fs::path& scenes_dir) {
  if (!is_scene_name(name)) {
    return Error{ErrorCode::kInvalid, "expected a scene's name of a-z, 0-9 and -, at most 64",
                 "scene"};
  }
  const fs::path path = scenes_dir / name / "scene.json";
  std::error_code ec;
  if (!fs::is_regular_file(path, ec))
    return Error{ErrorCode::kNotFound, "no scene of this name", std::string(name)};
  return path;
}

Result<fs::path> resolve_scene_path(std::string_view name_or_path, const fs::path& scenes_dir) {
  const fs::path path(name_or_path);
  std::error_code ec;
  if (fs::is_regular_file(path, ec)) return path;
  if (fs::is_regular_file(path / "scene.json", ec)) return path / "scene.json";
  if (is_scene_name(name_or_path)) return resolve_scene_name(name_or_path, scenes_dir);
  return Error{ErrorCode::kNotFound, "expected a scene file, a folder with scene.json, or a name",
               std::string(name_or_path)};
}

}  // namespace qray
