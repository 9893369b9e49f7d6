#include "core/import/polygon.h"

#include <cmath>
#include <numeric>

namespace qray {
namespace {

// Corners in the plane of two axes in which the polygon runs counterclockwise.
std::vector<Vec2> flattened(std::span<const Vec3> corners) {
  Vec3 n;  // Newell's, twice the area long
  for (size_t i = 0; i < corners.size(); ++i) {
    const Vec3 a = corners[i], b = corners[(i + 1) % corners.size()];
    n = n + Vec3{(a.y - b.y) * (a.z + b.z), (a.z - b.z) * (a.x + b.x), (a.x - b.x) * (a.y + b.y)};
  }
  const float x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
  const int up = x > y && x > z ? 0 : y > z ? 1 : 2;
  const int u = (up + 1) % 3, v = (up + 2) % 3;
  std::vector<Vec2> flat;
  for (const Vec3& p : corners) flat.push_back(n[up] < 0 ? Vec2{p[v], p[u]} : Vec2{p[u], p[v]});
  return flat;
}

// Twice the area of a triangle, positive where it runs counterclockwise.
float area(Vec2 a, Vec2 b, Vec2 c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); }

}  // namespace

std::vector<std::array<uint32_t, 3>> cut_polygon(std::span<const Vec3> corners) {
  if (corners.size() == 3) return {{0, 1, 2}};
  if (corners.size() == 4) {
    const Vec3 d02 = corners[2] - corners[0], d13 = corners[3] - corners[1];
    if (dot(d02, d02) < dot(d13, d13)) return {{0, 1, 2}, {0, 2, 3}};
    return {{0, 1, 3}, {1, 2, 3}};
  }
  const std::vector<Vec2> flat = flattened(corners);
  std::vector<uint32_t> left(corners.size());
  std::iota(left.begin(), left.end(), 0);
  std::vector<std::array<uint32_t, 3>> triangles;
  const auto is_ear = [&](uint32_t a, uint32_t b, uint32_t c) {
    if (!(area(flat[a], flat[b], flat[c]) > 0)) return false;
    for (const uint32_t p : left) {
      if (p != a && p != b && p != c && area(flat[a], flat[b], flat[p]) >= 0 &&
          area(flat[b], flat[c], flat[p]) >= 0 && area(flat[c], flat[a], flat[p]) >= 0)
        return false;
    }
    return true;
  };
  // What was made to have few ears must not take a cube of time.
  size_t tries_left = 8 * corners.size();
  for (size_t i = 0; left.size() > 3 && tries_left > 0; --tries_left) {
    const size_t n = left.size(), middle = (i + 1) % n;
    const uint32_t a = left[i % n], b = left[middle], c = left[(i + 2) % n];
    if (is_ear(a, b, c)) {
      triangles.push_back({a, b, c});
      left.erase(left.begin() + static_cast<std::ptrdiff_t>(middle));
    } else {
      ++i;
    }
  }
  for (size_t i = 2; i < left.size(); ++i) triangles.push_back({left[0], left[i - 1], left[i]});
  return triangles;
}

}  // namespace qray
