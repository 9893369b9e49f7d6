// The scene format's shapes as triangle meshes, fronts outward. The material is left unset.
#pragma once

#include "core/scene/scene.h"

namespace qray {

// A parallelogram; its front is the side edge1 x edge2 points to; uv (0, 0) at the origin.
Mesh make_quad(Vec3 origin, Vec3 edge1, Vec3 edge2);
// Axis-aligned; each face has its own vertices and uvs of 0..1.
Mesh make_box(Vec3 min, Vec3 max);
// A subdivided icosahedron, 20 * 4^subdivisions triangles with corners on the sphere; without uvs.
Mesh make_sphere(Vec3 center, float radius, int subdivisions);
// Upright (+y), a cone's frustum where the radii differ; u runs around, v upward.
Mesh make_cylinder(Vec3 base, float height, float radius, float top_radius, int segments,
                   bool caps);
// Its front is where `normal` points; uv is the disk in the unit square.
Mesh make_disk(Vec3 center, Vec3 normal, float radius, int segments);

}  // namespace qray
