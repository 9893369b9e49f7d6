// KHR_lights_punctual and cameras, placed by their nodes. Throws ImportFailure. One import.
#pragma once

#include "core/import/gltf_import.h"

namespace qray {

// `index_node`: "light" of a node's extension.
PunctualLight read_gltf_light(const JsonNode& index_node, const Transform& to_world,
                              GltfImport& import);
// Sets the picture's size too.
void read_gltf_camera(const JsonNode& camera, const JsonNode& node, const Transform& to_world,
                      GltfImport& import);

}  // namespace qray
