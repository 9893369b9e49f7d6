// A primitive that KHR_draco_mesh_compression has packed, unpacked into views of the document.
// Throws ImportFailure. One thread.
#pragma once

#include "core/import/gltf_import.h"

namespace qray {

// The model's accessors of the primitive, with their elements where they were unpacked to.
struct GltfUnpacked {
  std::map<std::string, GltfModel::Accessor> attributes;
  GltfModel::Accessor indices;
};

// `extension`: of `primitive`. What has no packed attribute is missing in the result.
GltfUnpacked unpack_draco(const JsonNode& extension, const GltfModel::Primitive& primitive,
                          GltfDocument& document);

}  // namespace qray
