#include "core/guide/directions26.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace qray {
namespace {

struct Dir {
  double x, y, z;
};
Dir operator*(Dir a, double s) { return {a.x * s, a.y * s, a.z * s}; }
Dir operator+(Dir a, Dir b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
double dot(Dir a, Dir b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Dir cross(Dir a, Dir b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Dir unit(Dir a) { return a * (1 / std::sqrt(dot(a, a))); }

using Polygon = std::vector<Dir>;  // a convex spherical polygon, counter-clockwise from outside

// The part of the polygon where dot(d, m) >= 0. Edges are arcs of great circles, so Sutherland and
// Hodgman's algorithm holds with interpolated, normalised points.
Polygon clip(const Polygon& polygon, Dir m) {
  Polygon result;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Dir a = polygon[i], b = polygon[(i + 1) % polygon.size()];
    const double da = dot(a, m), db = dot(b, m);
    if (da >= 0) result.push_back(a);
    if ((da >= 0) != (db >= 0)) result.push_back(unit(a * (db / (db - da)) + b * (da / (da - db))));
  }
  return result;
}

// Solid angle, as a fan of triangles (Van Oosterom and Strackee 1983).
double solid_angle(const Polygon& polygon) {
  double sum = 0;
  for (size_t i = 2; i < polygon.size(); ++i) {
    const Dir a = polygon[0], b = polygon[i - 1], c = polygon[i];
    sum += 2 * std::atan2(dot(a, cross(b, c)), 1 + dot(a, b) + dot(b, c) + dot(c, a));
  }
  return sum;
}

Dir to_dir(Vec3 v) { return {v.x, v.y, v.z}; }

// The 26 regions of the sphere nearest to each direction.
std::array<Polygon, kDirections26> make_regions() {
  std::array<Polygon, kDirections26> regions;
  std::array<Dir, kDirections26> s;
  for (int i = 0; i < kDirections26; ++i)
    s[static_cast<size_t>(i)] = unit(to_dir(directions26()[static_cast<size_t>(i)]));
  for (size_t i = 0; i < s.size(); ++i) {
    const Dir helper = std::abs(s[i].x) < 0.5 ? Dir{1, 0, 0} : Dir{0, 1, 0};
    const Dir t = unit(cross(helper, s[i])), b = cross(s[i], t);
    // A square of half-width atan(2) contains the region and stays in the open hemisphere.
    Polygon p = {unit(s[i] + t * 2 + b * 2), unit(s[i] + t * -2 + b * 2),
                 unit(s[i] + t * -2 + b * -2), unit(s[i] + t * 2 + b * -2)};
    for (size_t j = 0; j < s.size(); ++j)
      if (j != i) p = clip(p, s[i] + s[j] * -1);
    regions[i] = p;
  }
  return regions;
}

}  // namespace

const std::array<Vec3, kDirections26>& directions26() {
  static const std::array<Vec3, kDirections26> directions = [] {
    std::array<Vec3, kDirections26> d;
    size_t i = 0;
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z)
          if (x != 0 || y != 0 || z != 0) {
            d[i++] = normalize(
                Vec3{static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
          }
    return d;
  }();
  return directions;
}

int nearest_direction26(Vec3 d) {
  const float ax = std::abs(d.x), ay = std::abs(d.y), az = std::abs(d.z);
  const float hi = std::max(ax, std::max(ay, az)), lo = std::min(ax, std::min(ay, az));
  const float mid = std::max(std::min(ax, ay), std::min(std::max(ax, ay), az));
  // Cosines to the nearest face, edge and corner direction.
  const float face = hi, edge = (hi + mid) * 0.70710678f, corner = (hi + mid + lo) * 0.57735027f;
  const int count = corner > face && corner > edge ? 3 : edge > face ? 2 : 1;
  const float least = count == 3 ? lo : count == 2 ? mid : hi;  // components below it are dropped
  const auto step = [&](float v) { return std::abs(v) >= least ? (v < 0 ? -1 : 1) : 0; };
  const int code = (step(d.x) + 1) * 9 + (step(d.y) + 1) * 3 + step(d.z) + 1;
  return code < 13 ? code : code - 1;
}

std::array<float, kDirections26> hemisphere_shares26(Vec3 n) {
  static const std::array<Polygon, kDirections26> regions = make_regions();
  std::array<double, kDirections26> area;
  double sum = 0;
  for (size_t i = 0; i < regions.size(); ++i) {
    area[i] = std::max(0.0, solid_angle(clip(regions[i], to_dir(n))));
    sum += area[i];
  }
  std::array<float, kDirections26> shares;
  for (size_t i = 0; i < shares.size(); ++i) shares[i] = static_cast<float>(area[i] / sum);
  return shares;
}

}  // namespace qray
