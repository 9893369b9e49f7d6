#include "core/import/scene_folder.h"

#include <algorithm>

namespace qray {
namespace fs = std::filesystem;
namespace {

// As it is written: what leaves the folder and comes back would tell whether the way is there.
bool stays_within(const fs::path& folder, const fs::path& from, const fs::path& name) {
  if (name.is_absolute()) return false;
  ptrdiff_t depth = std::distance(from.begin(), from.end()) -  //
                    std::distance(folder.begin(), folder.end());
  for (const fs::path& part : name) {
    if (part == "..") {
      if (--depth < 0) return false;
    } else if (!part.empty() && part != ".") {
      ++depth;
    }
  }
  return true;
}

}  // namespace

fs::path scene_folder(const fs::path& file) {
  const fs::path folder = fs::absolute(file).parent_path();
  std::error_code ec;
  fs::path canonical = fs::canonical(folder, ec);
  return ec ? folder : canonical;
}

std::optional<fs::path> follow_within(const fs::path& folder, const fs::path& from,
                                      const std::string& name) {
  if (!stays_within(folder, from, name)) return std::nullopt;
  std::error_code ec;
  fs::path path = fs::canonical(from / name, ec);
  if (ec) return std::nullopt;
  const auto [end, ignored] = std::mismatch(folder.begin(), folder.end(), path.begin(), path.end());
  if (end != folder.end()) return std::nullopt;
  return path;
}

Result<fs::path> find_within(const fs::path& folder, const fs::path& from,
                             const std::string& name) {
  std::error_code ec;
  std::optional<fs::path> path = follow_within(folder, from, name);
  if (!path || !fs::is_regular_file(*path, ec))
    return Error{ErrorCode::kNotFound, "no such file in the scene's folder: \"" + name + "\"", ""};
  return *std::move(path);
}

}  // namespace qray
