// Shading normals from images: tangent-space normals (glTF 2.0, 3.9.3) and heights (Blinn 1978),
// by the triangle's own uv directions. What scatters then is no longer reciprocal: the normal is
// bent back until the mirror image of the eye's direction lies above the triangle (Keller et al.
// 2017, "The Iray Light Transport Simulation and Rendering System"), so it depends on the eye. In
// return no place is black for facing away from who sees it. Any thread.
#pragma once

#include "core/math/frame.h"
#include "core/render/material_textures.h"
#include "core/scene/surface.h"

namespace qray {

// A triangle's edges from its first vertex, in space and in uv.
struct TriangleEdges {
  Vec3 e1, e2;
  Vec2 uv1, uv2;
};
// `uvs`: of the mesh, one of its sets; `to_world`: an instance's, or null.
TriangleEdges triangle_edges(const Mesh& mesh, const Transform* to_world, uint32_t triangle,
                             const std::vector<Vec2>& uvs);
inline TriangleEdges triangle_edges(const Mesh& mesh, const Transform* to_world,
                                    uint32_t triangle) {
  return triangle_edges(mesh, to_world, triangle, mesh.uvs);
}

// About the unit normal n, with x in the triangle's uv directions: `turn` radians from the one in
// which u grows toward the one in which v does. Where they are none: any x.
Frame uv_frame(const TriangleEdges& edges, Vec3 n, float turn);

// The normal that a map says in place of the surface's ns. World space, unit.
Vec3 mapped_normal(const MaterialTextures& textures, TextureId map, float scale,
                   const TriangleEdges& edges, const SurfacePoint& surface);

// In place of the surface's ns, seen from wo. World space, unit.
Vec3 bent_normal(const MaterialTextures& textures, const Material& material,
                 const TriangleEdges& edges, const SurfacePoint& surface, Vec3 wo);

// The unit normal nearest to n, both in ng's hemisphere on wo's side, from which wo is seen and
// whose mirror image of wo is above ng.
Vec3 seen_normal(Vec3 n, Vec3 ng, Vec3 wo);

}  // namespace qray
