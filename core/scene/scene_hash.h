// SHA-256 of what a table depends on. The camera, the picture size and all names are left out.
// Geometry: positions, normals, uvs, triangles and which material index each mesh has, and
// instances. Materials: all parameters but emission, with the bytes of the texture files, and
// vertex colours. Lights: emissions, lights without an extent, and the environment with its image's
// values.
#pragma once

#include "core/base/result.h"
#include "core/scene/scene.h"

namespace qray {

Result<SceneHash> hash_scene(const Scene& scene);  // fails when a texture file cannot be read
// Of a scene that differs from one of this hash in its lights alone.
Result<SceneHash> hash_other_lights(const Scene& scene, SceneHash hash);

}  // namespace qray
