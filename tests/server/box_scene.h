// The scene of most tests of the server, and how they write it.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

namespace qray::server::test {

inline void write_text(const std::filesystem::path& path, const std::string& text) {
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path) << text;
}

// An open box under a light: a scene of a few triangles, loaded in no time.
inline constexpr const char* kBoxScene = R"({
  "name": "box", "size": [48, 40],
  "camera": {"position": [0, 1, 3], "target": [0, 1, 0], "up": [0, 1, 0], "vertical_fov_deg": 50},
  "materials": [
    {"name": "white", "type": "diffuse", "reflectance": [0.7, 0.7, 0.7]},
    {"name": "light", "type": "diffuse", "reflectance": 0.5, "emission": [10, 9, 8]}],
  "meshes": [
    {"name": "floor", "material": "white",
     "positions": [[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]], "quads": [[0, 1, 2, 3]]},
    {"name": "back", "material": "white",
     "positions": [[-1, 0, -1], [1, 0, -1], [1, 2, -1], [-1, 2, -1]], "quads": [[0, 1, 2, 3]]},
    {"name": "light", "material": "light",
     "positions": [[-0.3, 1.9, 0.3], [-0.3, 1.9, -0.3], [0.3, 1.9, -0.3], [0.3, 1.9, 0.3]],
     "quads": [[0, 1, 2, 3]]}]
})";

}  // namespace qray::server::test
