#include "core/import/fit_camera.h"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>

#include "core/scene/value_ranges.h"

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

// Share of each side of the bounding box (-x, +x, -y, ..) that surfaces parallel to it cover,
// within 5 % of it; with their fronts inside alone, or either way round.
std::array<float, 6> coverage(const Scene& scene, const Bounds3& box, bool fronts_alone) {
  const Vec3 extent = box.extent();
  double areas[6] = {};
  for_each_triangle(scene, [&](Vec3 a, Vec3 b, Vec3 c) {
    for (int side = 0; side < 6; ++side) {
      const int axis = side / 2;
      const bool high = side % 2 == 1;
      const float at = high ? box.hi[axis] : box.lo[axis], tolerance = 0.05f * extent[axis];
      if (!(std::abs(a[axis] - at) <= tolerance && std::abs(b[axis] - at) <= tolerance &&
            std::abs(c[axis] - at) <= tolerance))
        continue;
      const float outward = 0.5f * cross(b - a, c - a)[axis] * (high ? 1.0f : -1.0f);
      areas[side] += fronts_alone ? std::max(-outward, 0.0f) : std::abs(outward);
    }
  });
  std::array<float, 6> shares{};
  for (int side = 0; side < 6; ++side) {
    const float full = extent[(side / 2 + 1) % 3] * extent[(side / 2 + 2) % 3];
    if (full > 0) shares[static_cast<size_t>(side)] = static_cast<float>(areas[side]) / full;
  }
  return shares;
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
  if (box.empty() || !(box.radius() > 0 && box.radius() < kMaxCoordinate)) return camera;
  const Vec3 center = box.center(), extent = box.extent();
  camera.target = center;

  std::array<float, 6> covered{};
  if (scene.placed_triangle_count() <= kMaxTriangles)
    covered = coverage(scene, box, fronts_are_known);
  const auto walls = std::count_if(covered.begin(), covered.end() - 1,  // the other five sides
                                   [](float share) { return share > 0.5f; });
  const float front = covered[5];

  if (walls >= 4 && front < 0.1f) {
    camera.vertical_fov_deg = kBoxFovDeg;
    const float half = 0.525f * std::max(extent.x, extent.y);  // a margin of 5 %
    camera.position = {center.x, center.y, box.hi.z + half / half_tan(kBoxFovDeg)};
    return camera;
  }
  if (fronts_are_known && scene.placed_triangle_count() <= kMaxRoomTriangles)
    if (const std::optional<Camera> inside = view_of_room(scene, box)) return *inside;
  if (walls >= 4) {
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
