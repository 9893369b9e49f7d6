// Scene files written by a test into a folder of its own, and what loading them says.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <string_view>

#include "core/base/file.h"
#include "core/import/load_scene.h"
#include "tests/support/scratch.h"

namespace qray::test {

class SceneFolder {
 public:
  std::filesystem::path write(const std::string& name, std::string_view text) const {
    const Bytes bytes(text.begin(), text.end());
    EXPECT_TRUE(write_file_atomic(folder_ / name, bytes).ok());
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
