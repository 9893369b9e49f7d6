// The surface at a hit: where, which way it faces, and its texture coordinates.
#pragma once

#include <optional>

#include "core/scene/scene.h"

namespace qray {

// How far off their surface rays start, of the largest coordinate: three times the rounding noise
// seen of o + t d.
constexpr float kRayOffset = 0x1p-19f;

struct SurfacePoint {
  Vec3 p;   // metres
  Vec3 ng;  // geometric normal, unit, by the winding; not flipped
  Vec3 ns;  // shading normal, unit, in ng's hemisphere
  TexturePoint uv{};
  std::optional<Rgb> color{};  // of the mesh's vertices
};

// Replaces ns, uv and colour by the vertices' values, interpolated, where the mesh has them.
// `barycentric`: the weights of the triangle's second and third vertex. `normals_to_world`: an
// instance's, or null.
inline void interpolate_vertices(const Mesh& mesh, uint32_t triangle, Vec2 barycentric,
                                 SurfacePoint& surface, const Mat3* normals_to_world = nullptr) {
  const auto& tri = mesh.triangles[triangle];
  const float b1 = barycentric.x, b2 = barycentric.y, b0 = 1 - b1 - b2;
  if (!mesh.normals.empty()) {
    Vec3 sum = mesh.normals[tri[0]] * b0 + mesh.normals[tri[1]] * b1 + mesh.normals[tri[2]] * b2;
    float sum_length = length(sum);
    if (normals_to_world && sum_length > 1e-6f) {
      sum = *normals_to_world * (sum / sum_length);
      sum_length = length(sum);
    }
    if (sum_length > 1e-6f) surface.ns = sum / sum_length;
    if (dot(surface.ns, surface.ng) < 0) surface.ns = -surface.ns;
  }
  if (!mesh.colors.empty())
    surface.color = mesh.colors[tri[0]] * b0 + mesh.colors[tri[1]] * b1 + mesh.colors[tri[2]] * b2;
  const auto at = [&](const std::vector<Vec2>& uvs) {
    return uvs[tri[0]] * b0 + uvs[tri[1]] * b1 + uvs[tri[2]] * b2;
  };
  if (!mesh.uvs.empty()) surface.uv = at(mesh.uvs);
  if (!mesh.second_uvs.empty()) surface.uv.second_uv = at(mesh.second_uvs);
}

// Asks the memory for the triangle's vertices' numbers, and then for what interpolate_vertices()
// reads of them, so that many may wait at once. Inlined, since g++ drops calls of functions that do
// nothing but this.
[[gnu::always_inline]] inline void prefetch_triangle(const Mesh& mesh, uint32_t triangle) {
  __builtin_prefetch(&mesh.triangles[triangle]);
}
[[gnu::always_inline]] inline void prefetch_vertices(const Mesh& mesh, uint32_t triangle) {
  for (const uint32_t vertex : mesh.triangles[triangle]) {
    if (!mesh.normals.empty()) __builtin_prefetch(&mesh.normals[vertex]);
    if (!mesh.uvs.empty()) __builtin_prefetch(&mesh.uvs[vertex]);
  }
}

}  // namespace qray
