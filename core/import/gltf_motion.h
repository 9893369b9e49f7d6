// What a glTF document's animations move, as tracks of its nodes. Throws ImportFailure. One import.
#pragma once

#include <map>

#include "core/import/gltf_accessor.h"
#include "core/scene/motion.h"

namespace qray {

// By node. All animations play at once; where several move the same of a node, the first counts.
std::map<int, NodeMotion> read_gltf_motions(GltfImport& import);

}  // namespace qray
