#include "core/import/primitives.h"

#include <map>

#include "core/math/frame.h"

namespace qray {
namespace {

constexpr Vec2 kQuadUvs[] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};

void add_quad(Mesh& mesh, Vec3 origin, Vec3 edge1, Vec3 edge2) {
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  for (const Vec2 uv : kQuadUvs) {
    mesh.positions.push_back(origin + edge1 * uv.x + edge2 * uv.y);
    mesh.uvs.push_back(uv);
  }
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first, first + 2, first + 3});
}

// A fan around `center` in the plane of x and y, front along x cross y.
void add_disk(Mesh& mesh, Vec3 center, Vec3 x, Vec3 y, float radius, int segments) {
  const Vec3 normal = normalize(cross(x, y));
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  mesh.positions.push_back(center);
  mesh.uvs.push_back({0.5f, 0.5f});
  for (int i = 0; i < segments; ++i) {
    const float phi = 2 * kPi * static_cast<float>(i) / static_cast<float>(segments);
    const float c = std::cos(phi), s = std::sin(phi);
    mesh.positions.push_back(center + x * (radius * c) + y * (radius * s));
    mesh.uvs.push_back({0.5f + 0.5f * c, 0.5f + 0.5f * s});
  }
  mesh.normals.resize(mesh.positions.size(), normal);
  const auto count = static_cast<uint32_t>(segments);
  for (uint32_t i = 0; i < count; ++i)
    mesh.triangles.push_back({first, first + 1 + i, first + 1 + (i + 1) % count});
}

}  // namespace

Mesh make_quad(Vec3 origin, Vec3 edge1, Vec3 edge2) {
  Mesh mesh;
  add_quad(mesh, origin, edge1, edge2);
  return mesh;
}

Mesh make_box(Vec3 min, Vec3 max) {
  const Vec3 d = max - min;
  const Vec3 x{d.x, 0, 0}, y{0, d.y, 0}, z{0, 0, d.z};
  Mesh mesh;
  add_quad(mesh, min, y, x);
  add_quad(mesh, min + z, x, y);
  add_quad(mesh, min, x, z);
  add_quad(mesh, min + y, z, x);
  add_quad(mesh, min, z, y);
  add_quad(mesh, min + x, y, z);
  return mesh;
}

Mesh make_sphere(Vec3 center, float radius, int subdivisions) {
  const float g = (1 + std::sqrt(5.0f)) / 2;
  std::vector<Vec3> corners = {{-1, g, 0}, {1, g, 0}, {-1, -g, 0}, {1, -g, 0},
                               {0, -1, g}, {0, 1, g}, {0, -1, -g}, {0, 1, -g},
                               {g, 0, -1}, {g, 0, 1}, {-g, 0, -1}, {-g, 0, 1}};
  for (Vec3& v : corners) v = normalize(v);
  std::vector<std::array<uint32_t, 3>> triangles = {
      {0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
      {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
      {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int step = 0; step < subdivisions; ++step) {
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> midpoints;
    const auto midpoint = [&](uint32_t a, uint32_t b) {
      const auto [it, is_new] =
          midpoints.try_emplace(std::minmax(a, b), static_cast<uint32_t>(corners.size()));
      if (is_new) corners.push_back(normalize(corners[a] + corners[b]));
      return it->second;
    };
    std::vector<std::array<uint32_t, 3>> finer;
    finer.reserve(triangles.size() * 4);
    for (const auto& [a, b, c] : triangles) {
      const uint32_t ab = midpoint(a, b), bc = midpoint(b, c), ca = midpoint(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    triangles = std::move(finer);
  }
  Mesh mesh;
  mesh.triangles = std::move(triangles);
  for (const Vec3 v : corners) mesh.positions.push_back(center + v * radius);
  mesh.normals = std::move(corners);
  return mesh;
}

Mesh make_cylinder(Vec3 base, float height, float radius, float top_radius, int segments,
                   bool caps) {
  Mesh mesh;
  const Vec3 up{0, height, 0};
  for (int i = 0; i <= segments; ++i) {
    const float u = static_cast<float>(i) / static_cast<float>(segments);
    const float phi = 2 * kPi * u;
    const Vec3 out{std::cos(phi), 0, -std::sin(phi)};
    mesh.positions.push_back(base + out * radius);
    mesh.positions.push_back(base + up + out * top_radius);
    mesh.uvs.insert(mesh.uvs.end(), {{u, 0}, {u, 1}});
    // Perpendicular to the slope (top_radius - radius, height).
    const Vec3 normal = normalize(Vec3{out.x * height, radius - top_radius, out.z * height});
    mesh.normals.insert(mesh.normals.end(), {normal, normal});
  }
  for (uint32_t i = 0; i < static_cast<uint32_t>(segments); ++i) {
    const uint32_t a = 2 * i;
    mesh.triangles.push_back({a, a + 2, a + 3});
    mesh.triangles.push_back({a, a + 3, a + 1});
  }
  if (caps) {
    const Vec3 x{1, 0, 0}, z{0, 0, 1};
    add_disk(mesh, base, x, z, radius, segments);
    add_disk(mesh, base + up, z, x, top_radius, segments);
  }
  return mesh;
}

Mesh make_disk(Vec3 center, Vec3 normal, float radius, int segments) {
  const Frame frame(normalize(normal));
  Mesh mesh;
  add_disk(mesh, center, frame.x, frame.y, radius, segments);
  return mesh;
}

}  // namespace qray
