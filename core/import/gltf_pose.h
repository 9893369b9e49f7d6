// Vertices where morph targets and skins put them, at the time that is read. Throws ImportFailure.
// One import.
#pragma once

#include "core/import/gltf_accessor.h"
#include "core/scene/scene.h"

namespace qray {

struct GltfPose {
  std::vector<double> weights;    // of the morph targets; what is missing is 0
  std::vector<Transform> joints;  // of a skin, from the mesh's space to the world; empty: none
};

// The joints of a skin, `to_world` of each of the document's nodes; nullopt, with a warning, where
// the scene does not have one of them.
std::optional<std::vector<Transform>> read_gltf_joints(
    GltfImport& import, int skin, const std::vector<std::optional<Transform>>& to_world);

// An attribute's accessor, none where the primitive does not have it; its count is checked.
using GltfAttribute =
    std::function<std::optional<GltfAccessor>(const std::string& name, int components)>;

// Adds what one target moves. `wanted`: the vertices that the mesh keeps; empty: all.
void add_gltf_target(Mesh& mesh, const GltfAttribute& target, float weight,
                     std::span<const uint32_t> wanted);
// Puts the vertices into the world.
void apply_gltf_skin(Mesh& mesh, const JsonNode& primitive, const GltfAttribute& find,
                     std::span<const Transform> joints, std::span<const uint32_t> wanted);

}  // namespace qray
