// What a glTF document's animations move, as tracks of its nodes. Throws ImportFailure. One import.
#pragma once

#include <map>

#include "core/import/gltf_accessor.h"
#include "core/scene/motion.h"

namespace qray {

// By node. All animations play at once; where several move the same of a node, the first counts.
using GltfMotions = std::map<int, std::shared_ptr<const NodeMotion>>;
GltfMotions read_gltf_motions(GltfImport& import);

}  // namespace qray
