// Wavefront OBJ; its MTL through tinyobjloader (mtl.h). Errors name the line. Throws ImportFailure.
// Any thread.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/import/load_watch.h"
#include "core/scene/scene.h"
#include "core/scene/validate.h"

namespace qray {

// Material and texture ids count from 0 in these lists. One mesh a group and material.
struct ObjContents {
  std::vector<Mesh> meshes;
  std::vector<Material> materials;
  std::vector<Texture> textures;
  std::vector<std::string> warnings;
};

ObjContents read_obj(const std::filesystem::path& path, const SceneLimits& limits,
                     const LoadWatch& watch = {});

}  // namespace qray
