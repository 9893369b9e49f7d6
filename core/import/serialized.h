// Mitsuba's .serialized meshes, versions 3 and 4: deflated vertices and triangles of one of the
// file's shapes. Throws ImportFailure naming the byte. Any thread.
#pragma once

#include <span>
#include <string>

#include "core/scene/scene.h"
#include "core/scene/validate.h"

namespace qray {

// `file` is the name for messages. Normals and uvs as stored; `face_normals`: the shape asks to be
// drawn flat.
struct SerializedShape {
  Mesh mesh;
  bool face_normals = false;
};
SerializedShape read_serialized(std::span<const uint8_t> bytes, size_t shape_index,
                                const SceneLimits& limits, const std::string& file);

}  // namespace qray
