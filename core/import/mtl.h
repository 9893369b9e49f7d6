// MTL materials as ours. MTL has no units and few rules, so values are brought into range rather
// than refused; what is lost is a warning. Only obj.cpp includes this.
#pragma once

#include "core/import/obj.h"

namespace tinyobj {
struct material_t;
}

namespace qray {

// Appends to out.materials in order, and to out.textures. Texture paths start in `folder`.
void convert_materials(const std::vector<tinyobj::material_t>& materials,
                       const std::filesystem::path& folder, ObjContents& out);

}  // namespace qray
