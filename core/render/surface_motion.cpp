#include "core/render/surface_motion.h"

namespace qray {
namespace {

Vec3 point_of(const MeshShading& mesh, const Hit& hit) {
  const auto& corners = mesh.mesh->triangles[hit.triangle];
  const std::vector<Vec3>& at = mesh.mesh->positions;
  const float b1 = hit.barycentric.x, b2 = hit.barycentric.y;
  const Vec3 p = at[corners[0]] * (1 - b1 - b2) + at[corners[1]] * b1 + at[corners[2]] * b2;
  return mesh.to_world ? mesh.to_world->point(p) : p;
}

Vec3 moved_on(const Sphere& from, Vec3 p, const Sphere& to) {
  if (from == to) return {};
  const Vec3 outward = normalize(p - from.center);
  return to.center + to.to_local.transposed() * (from.to_local * outward) * to.radius - p;
}

}  // namespace

std::optional<Vec3> surface_motion(const PreparedScene& scene, const Hit& hit, Vec3 p,
                                   const PreparedScene& other) {
  if (other.meshes.size() != scene.meshes.size()) return std::nullopt;
  const MeshShading& from = scene.meshes[hit.mesh.value];
  const MeshShading& to = other.meshes[hit.mesh.value];
  if (from.sphere && to.sphere) return moved_on(*from.sphere, p, *to.sphere);
  if (from.sphere || to.sphere || from.mesh->triangles.size() != to.mesh->triangles.size())
    return std::nullopt;
  return point_of(to, hit) - point_of(from, hit);
}

}  // namespace qray
