#include "core/import/fit_camera.h"

namespace qray {
namespace {

constexpr float kBoxFovDeg = 39.3f;  // of the Cornell box photographs
constexpr float kRoomFovDeg = 70;

// Share of one side of the bounding box that surfaces parallel to it cover, within 5 % of it.
float coverage(const Scene& scene, const Bounds3& box, int axis, bool high) {
  const Vec3 extent = box.extent();
  const float side = high ? box.hi[axis] : box.lo[axis];
  const float tolerance = 0.05f * extent[axis];
  double area = 0;
  for (const Placement& placed : scene.placements()) {
    if (!placed.mesh) continue;
    const Mesh& mesh = *placed.mesh;
    for (const auto& tri : mesh.triangles) {
      const Vec3 p[] = {placed.at(mesh.positions[tri[0]]), placed.at(mesh.positions[tri[1]]),
                        placed.at(mesh.positions[tri[2]])};
      bool near = true;
      for (const Vec3 v : p) near = near && std::abs(v[axis] - side) <= tolerance;
      if (near) area += 0.5 * std::abs(cross(p[1] - p[0], p[2] - p[0])[axis]);
    }
  }
  const float full = extent[(axis + 1) % 3] * extent[(axis + 2) % 3];
  return full > 0 ? static_cast<float>(area) / full : 0;
}

float half_tan(float fov_deg) { return std::tan(fov_deg * (kPi / 360)); }

}  // namespace

Camera fit_camera(const Scene& scene) {
  const Bounds3 box = scene.bounds();
  Camera camera;
  if (box.empty() || !(box.radius() > 0)) return camera;
  const Vec3 center = box.center(), extent = box.extent();
  camera.target = center;

  int walls = 0;  // of the other five sides
  for (int axis = 0; axis < 3; ++axis)
    for (const bool high : {false, true})
      if (!(axis == 2 && high) && coverage(scene, box, axis, high) > 0.5f) ++walls;
  const float front = coverage(scene, box, 2, true);

  if (walls >= 4 && front < 0.1f) {
    camera.vertical_fov_deg = kBoxFovDeg;
    const float half = 0.525f * std::max(extent.x, extent.y);  // a margin of 5 %
    camera.position = {center.x, center.y, box.hi.z + half / half_tan(kBoxFovDeg)};
  } else if (walls >= 4) {
    camera.vertical_fov_deg = kRoomFovDeg;
    camera.position = {center.x, center.y, box.hi.z - 0.1f * extent.z};
  } else {
    camera.vertical_fov_deg = kBoxFovDeg;
    const float distance = box.radius() / std::sin(kBoxFovDeg * (kPi / 360));
    camera.position = center + normalize(Vec3{0.4f, 0.3f, 1}) * distance;
  }
  return camera;
}

}  // namespace qray
