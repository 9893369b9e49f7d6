// The surface at a hit: position, normals and texture coordinates interpolated from the mesh.
#pragma once

#include "core/scene/scene.h"

namespace qray {

struct SurfacePoint {
  Vec3 p;       // metres; from barycentrics, so more exact than o + t d
  Vec3 ng;      // geometric normal, unit, by the winding; not flipped
  Vec3 ns;      // shading normal, unit, in ng's hemisphere
  Vec2 uv;
  float area = 0;  // of the triangle, m^2
  MaterialId material;
};

inline SurfacePoint surface_at(const Mesh& mesh, uint32_t triangle, Vec2 barycentric) {
  const auto& tri = mesh.triangles[triangle];
  const float b1 = barycentric.x, b2 = barycentric.y, b0 = 1 - b1 - b2;
  const Vec3 p0 = mesh.positions[tri[0]], p1 = mesh.positions[tri[1]], p2 = mesh.positions[tri[2]];
  SurfacePoint s;
  s.p = p0 * b0 + p1 * b1 + p2 * b2;
  const Vec3 n = cross(p1 - p0, p2 - p0);
  const float n_length = length(n);
  s.area = 0.5f * n_length;
  s.ng = n / n_length;
  s.ns = s.ng;
  if (!mesh.normals.empty()) {
    const Vec3 sum =
        mesh.normals[tri[0]] * b0 + mesh.normals[tri[1]] * b1 + mesh.normals[tri[2]] * b2;
    const float sum_length = length(sum);
    if (sum_length > 1e-6f) s.ns = sum / sum_length;
    if (dot(s.ns, s.ng) < 0) s.ns = -s.ns;
  }
  if (!mesh.uvs.empty()) s.uv = mesh.uvs[tri[0]] * b0 + mesh.uvs[tri[1]] * b1 + mesh.uvs[tri[2]] * b2;
  s.material = mesh.material;
  return s;
}

}  // namespace qray
