// glTF's primitives as meshes in their own space, uvs with v upward, with their materials. Throws
// ImportFailure. One import.
#pragma once

#include "core/import/gltf_material.h"
#include "core/import/gltf_pose.h"

namespace qray {

class GltfMeshes {
 public:
  explicit GltfMeshes(GltfImport& import) : import_(import) {}
  // Without triangles: points or lines, of which was warned. With a pose that has joints the mesh
  // is in the world.
  Mesh read(int mesh, int primitive, const GltfMaterials::Converted& material,
            const GltfPose& pose);

 private:
  void read_colors(Mesh& mesh, const GltfAccessor& colors, std::span<const uint32_t> wanted,
                   const GltfMaterials::Converted& material);

  GltfImport& import_;
  size_t triangle_count_ = 0;
};

}  // namespace qray
