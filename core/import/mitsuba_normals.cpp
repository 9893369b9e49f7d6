#include "core/import/mitsuba_normals.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "core/math/hash.h"

namespace qray {
namespace {

Vec3 unit_or_zero(Vec3 v) {
  const float norm = length(v);
  return norm > 0 && std::isfinite(norm) ? v / norm : Vec3{0, 0, 0};
}

Vec3 face_normal(const Mesh& mesh, const std::array<uint32_t, 3>& t) {
  const Vec3 p = mesh.positions[t[0]];
  return unit_or_zero(cross(mesh.positions[t[1]] - p, mesh.positions[t[2]] - p));
}

float corner_angle(const Mesh& mesh, const std::array<uint32_t, 3>& t, size_t corner) {
  const Vec3 p = mesh.positions[t[corner]];
  const Vec3 a = unit_or_zero(mesh.positions[t[(corner + 1) % 3]] - p);
  const Vec3 b = unit_or_zero(mesh.positions[t[(corner + 2) % 3]] - p);
  return std::acos(std::clamp(dot(a, b), -1.0f, 1.0f));
}

// A vertex that only faces without an area use has any direction.
Vec3 finished(Vec3 sum) {
  const Vec3 n = unit_or_zero(sum);
  return length(n) > 0 ? n : Vec3{1, 0, 0};
}

struct PositionHash {
  size_t operator()(Vec3 p) const {
    const auto bits = [](float v) { return static_cast<uint64_t>(std::bit_cast<uint32_t>(v + 0)); };
    return hash_combine(bits(p.x) << 32 | bits(p.y), bits(p.z));
  }
};

}  // namespace

void smooth_normals(Mesh& mesh) {
  mesh.normals.assign(mesh.positions.size(), Vec3{0, 0, 0});
  for (const auto& t : mesh.triangles) {
    const Vec3 n = face_normal(mesh, t);
    for (size_t corner = 0; corner < 3; ++corner)
      mesh.normals[t[corner]] += n * corner_angle(mesh, t, corner);
  }
  for (Vec3& n : mesh.normals) n = finished(n);
}

void smooth_normals(Mesh& mesh, float max_angle_deg) {
  // The corners at each position; of a fan of thousands only the first count, as its cost is their
  // number's square.
  constexpr size_t kMaxCorners = 256;
  struct CornerRef {
    uint32_t triangle, corner;
  };
  std::unordered_map<Vec3, std::vector<CornerRef>, PositionHash> corners;
  std::vector<Vec3> faces;
  faces.reserve(mesh.triangles.size());
  for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    faces.push_back(face_normal(mesh, mesh.triangles[i]));
    for (uint32_t c = 0; c < 3; ++c) {
      std::vector<CornerRef>& at = corners[mesh.positions[mesh.triangles[i][c]]];
      if (at.size() < kMaxCorners) at.push_back({i, c});
    }
  }
  const float least_cos = std::cos(max_angle_deg * (kPi / 180));
  Mesh out;
  out.name = std::move(mesh.name);
  out.material = mesh.material;
  for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto first = static_cast<uint32_t>(out.positions.size());
    for (const uint32_t v : mesh.triangles[i]) {
      Vec3 sum{0, 0, 0};
      for (const CornerRef& other : corners[mesh.positions[v]])
        if (dot(faces[i], faces[other.triangle]) >= least_cos || other.triangle == i)
          sum += faces[other.triangle] *
                 corner_angle(mesh, mesh.triangles[other.triangle], other.corner);
      out.positions.push_back(mesh.positions[v]);
      out.normals.push_back(finished(length(sum) > 0 ? sum : faces[i]));
      if (!mesh.uvs.empty()) out.uvs.push_back(mesh.uvs[v]);
    }
    out.triangles.push_back({first, first + 1, first + 2});
  }
  mesh = std::move(out);
}

}  // namespace qray
