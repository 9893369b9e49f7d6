#include "core/import/fit_camera.h"

#include <limits>
#include <optional>

namespace qray {
namespace {

constexpr float kBoxFovDeg = 39.3f;  // of the Cornell box photographs
constexpr float kRoomFovDeg = 70;
// Of more, instances and all, it is not asked what they cover.
constexpr size_t kMaxTriangles = 20'000'000;
constexpr size_t kMaxRoomTriangles = 300'000;  // 1300 rays look at each

// `see(a, b, c)` for every triangle in the scene's space.
template <class F>
void for_each_triangle(const Scene& scene, const F& see) {
  for (const Placement& placed : scene.placements()) {
    if (!placed.mesh) continue;
    // A mirroring map turns the winding, and keeps fronts in front.
    const bool mirrored = placed.to_world && placed.to_world->determinant() < 0;
    const Mesh& mesh = *placed.mesh;
    for (const auto& tri : mesh.triangles)
      see(placed.at(mesh.positions[tri[0]]), placed.at(mesh.positions[tri[mirrored ? 2 : 1]]),
          placed.at(mesh.positions[tri[mirrored ? 1 : 2]]));
  }
}

// Share of one side of the bounding box that surfaces parallel to it cover, within 5 % of it; with
// their fronts inside alone, or either way round.
float coverage(const Scene& scene, const Bounds3& box, int axis, bool high, bool fronts_alone) {
  const Vec3 extent = box.extent();
  const float side = high ? box.hi[axis] : box.lo[axis];
  const float tolerance = 0.05f * extent[axis];
  double area = 0;
  for_each_triangle(scene, [&](Vec3 a, Vec3 b, Vec3 c) {
    for (const Vec3 v : {a, b, c})
      if (!(std::abs(v[axis] - side) <= tolerance)) return;
    const float outward = 0.5f * cross(b - a, c - a)[axis] * (high ? 1.0f : -1.0f);
    area += fronts_alone ? std::max(-outward, 0.0f) : std::abs(outward);
  });
  const float full = extent[(axis + 1) % 3] * extent[(axis + 2) % 3];
  return full > 0 ? static_cast<float>(area) / full : 0;
}

class Surroundings {
 public:
  explicit Surroundings(const Scene& scene) {
    for_each_triangle(scene, [this](Vec3 a, Vec3 b, Vec3 c) {
      triangles_.push_back({a, b - a, c - a});
    });
  }

  struct Hit {
    float distance = std::numeric_limits<float>::infinity();
    bool front = false;
  };
  Hit look(Vec3 from, Vec3 d) const {  // Moeller and Trumbore 1997
    Hit hit;
    for (const Triangle& t : triangles_) {
      const Vec3 p = cross(d, t.edge2);
      const float det = dot(t.edge1, p);
      if (det == 0) continue;
      const Vec3 s = from - t.corner;
      const float u = dot(s, p) / det;
      if (!(u >= 0 && u <= 1)) continue;
      const Vec3 q = cross(s, t.edge1);
      const float v = dot(d, q) / det;
      const float distance = dot(t.edge2, q) / det;
      if (v >= 0 && u + v <= 1 && distance > 0 && distance < hit.distance)
        hit = {distance, det > 0};
    }
    return hit;
  }

 private:
  struct Triangle {
    Vec3 corner, edge1, edge2;
  };
  std::vector<Triangle> triangles_;
};

// The longest free line, about level, through one of 27 places inside the box that fronts surround.
std::optional<Camera> view_of_room(const Scene& scene, const Bounds3& box) {
  constexpr int kAround = 16;
  const Surroundings surroundings(scene);
  Camera best;
  // A room takes up most of the scene, a gap between things does not.
  float longest = 0.5f * std::max(box.extent().x, box.extent().z);
  bool found = false;
  for (int place = 0; place < 27; ++place) {
    const Vec3 share{static_cast<float>(1 + place % 3), static_cast<float>(1 + place / 3 % 3),
                     static_cast<float>(1 + place / 9)};
    const Vec3 extent = box.extent();
    const Vec3 from = box.lo + Vec3{extent.x * share.x, extent.y * share.y, extent.z * share.z} / 4;
    int fronts = 0;
    float free[kAround];
    for (int i = 0; i < 3 * kAround; ++i) {  // level, upward, downward
      const float angle = static_cast<float>(i % kAround) * (2 * kPi / kAround);
      const float up = static_cast<float>((i / kAround + 1) % 3 - 1);
      const Surroundings::Hit hit =
          surroundings.look(from, normalize(Vec3{std::sin(angle), up, std::cos(angle)}));
      if (hit.front) ++fronts;
      if (up == 0) free[i % kAround] = hit.front ? hit.distance : 0;
    }
    if (fronts < 3 * kAround * 3 / 4) continue;  // a quarter may be windows
    for (int i = 0; i < kAround; ++i) {
      const float line = free[i] + free[(i + kAround / 2) % kAround];
      if (!(line > longest * 1.001f)) continue;
      longest = line;
      found = true;
      const float angle = static_cast<float>(i) * (2 * kPi / kAround);
      best.position = from + Vec3{std::sin(angle), 0, std::cos(angle)} * (0.9f * free[i]);
      best.target = from;
    }
  }
  if (!found || best.position == best.target) return {};
  best.vertical_fov_deg = kRoomFovDeg;
  return best;
}

float half_tan(float fov_deg) { return std::tan(fov_deg * (kPi / 360)); }

}  // namespace

Camera fit_camera(const Scene& scene, bool fronts_are_known) {
  const Bounds3 box = scene.bounds();
  Camera camera;
  if (box.empty() || !(box.radius() > 0)) return camera;
  const Vec3 center = box.center(), extent = box.extent();
  camera.target = center;

  int walls = 0;  // of the other five sides
  float front = 0;
  if (scene.placed_triangle_count() <= kMaxTriangles) {
    for (int axis = 0; axis < 3; ++axis)
      for (const bool high : {false, true})
        if (!(axis == 2 && high) && coverage(scene, box, axis, high, fronts_are_known) > 0.5f)
          ++walls;
    front = coverage(scene, box, 2, true, fronts_are_known);
  }

  if (walls >= 4 && front < 0.1f) {
    camera.vertical_fov_deg = kBoxFovDeg;
    const float half = 0.525f * std::max(extent.x, extent.y);  // a margin of 5 %
    camera.position = {center.x, center.y, box.hi.z + half / half_tan(kBoxFovDeg)};
  } else if (walls >= 4 && !fronts_are_known) {
    camera.vertical_fov_deg = kRoomFovDeg;
    camera.position = {center.x, center.y, box.hi.z - 0.1f * extent.z};
  } else {
    if (fronts_are_known && scene.placed_triangle_count() <= kMaxRoomTriangles)
      if (const std::optional<Camera> inside = view_of_room(scene, box)) return *inside;
    camera.vertical_fov_deg = kBoxFovDeg;
    const float distance = box.radius() / std::sin(kBoxFovDeg * (kPi / 360));
    camera.position = center + normalize(Vec3{0.4f, 0.3f, 1}) * distance;
  }
  return camera;
}

}  // namespace qray
