// glTF's primitives as meshes in their own space, uvs with v upward, with their materials. Throws
// ImportFailure. One import.
#pragma once

#include "core/import/gltf_material.h"

namespace qray {

class GltfAccessor;

class GltfMeshes {
 public:
  explicit GltfMeshes(GltfImport& import) : import_(import) {}
  // Without triangles: points or lines, of which was warned.
  Mesh read(int mesh, int primitive, const GltfMaterials::Converted& material);

 private:
  void read_colors(Mesh& mesh, const GltfAccessor& colors, std::span<const uint32_t> wanted,
                   const GltfMaterials::Converted& material);

  GltfImport& import_;
  size_t triangle_count_ = 0;
  bool warned_of_targets_ = false;
};

}  // namespace qray
