// Stanford PLY: ascii and binary of either byte order; positions, normals, texture coordinates,
// colours and polygons, which are cut. Other properties are skipped. Throws ImportFailure naming
// the line (header, ascii) or the byte (binary). Any thread.
#pragma once

#include <filesystem>

#include "core/scene/scene.h"
#include "core/scene/validate.h"

namespace qray {

Mesh read_ply(const std::filesystem::path& path, const SceneLimits& limits);

}  // namespace qray
