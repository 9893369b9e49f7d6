#include "core/import/scene_entry.h"

#include <algorithm>
#include <filesystem>
#include <vector>

namespace qray {
namespace {

constexpr int kNoScene = 5;

// The lower, the more likely it is the scene and not a part of one.
int rank_of(const std::filesystem::path& name) {
  const std::string file = name.filename().string(), extension = name.extension().string();
  if (file == "scene.json") return 0;
  if (file.starts_with('.')) return kNoScene;
  if (extension == ".gltf" || extension == ".glb") return 1;
  if (extension == ".xml") return 2;
  if (extension == ".obj") return 3;
  return extension == ".ply" ? 4 : kNoScene;
}

}  // namespace

Result<std::string> find_scene_entry(std::span<const std::string> names) {
  std::vector<std::string> best;
  std::pair<ptrdiff_t, int> least{};
  for (const std::string& name : names) {
    const std::pair<ptrdiff_t, int> key{std::count(name.begin(), name.end(), '/'), rank_of(name)};
    if (key.second == kNoScene) continue;
    if (best.empty() || key < least) {
      least = key;
      best.clear();
    }
    if (key == least) best.push_back(name);
  }
  if (best.empty())
    return Error{ErrorCode::kNotFound,
                 "expected a scene.json, .gltf, .glb, .xml, .obj or .ply file", ""};
  if (best.size() > 1)
    return Error{ErrorCode::kInvalid,
                 "\"" + best[0] + "\" and \"" + best[1] + "\" may both be the scene: name one", ""};
  return best.front();
}

}  // namespace qray
