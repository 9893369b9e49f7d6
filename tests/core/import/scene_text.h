// Scene files written by a test into a folder of its own, and what loading them says.
#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <string_view>

#include "core/import/load_scene.h"
#include "tests/support/scratch.h"

namespace qray::test {

class SceneFolder {
 public:
  std::filesystem::path write(const std::string& name, std::string_view text) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    std::ofstream out(folder_ / name, std::ios::binary);
    out << text;
    EXPECT_TRUE(out.flush().good());
    return folder_ / name;
  }
  Result<LoadedScene> load(const std::string& name, std::string_view text) const {
    return load_scene(write(name, text));
  }
  // The error's text; "" when it loads.
  std::string failure(const std::string& name, std::string_view text) const {
    const auto loaded = load(name, text);
    return loaded.ok() ? "" : loaded.error().text();
  }
  const std::filesystem::path& path() const { return folder_.path(); }

 private:
  ScratchFolder folder_;
};

// The unit normal of a triangle by its winding.
inline Vec3 front(const Mesh& mesh, size_t triangle) {
  const auto& t = mesh.triangles[triangle];
  const Vec3 p = mesh.positions[t[0]];
  return normalize(cross(mesh.positions[t[1]] - p, mesh.positions[t[2]] - p));
}

}  // namespace qray::test
