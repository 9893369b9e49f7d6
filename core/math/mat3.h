// A 3x3 matrix of floats: rotations, and the maps of normals. Plain data.
#pragma once

#include <array>

#include "core/math/vec.h"

namespace qray {

struct Mat3 {
  std::array<Vec3, 3> rows{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};

  // Counter-clockwise seen from +y.
  static Mat3 rotation_y(float deg) {
    const float a = deg * (kPi / 180), c = std::cos(a), s = std::sin(a);
    return {{Vec3{c, 0, s}, Vec3{0, 1, 0}, Vec3{-s, 0, c}}};
  }
  Mat3 transposed() const {
    return {{Vec3{rows[0].x, rows[1].x, rows[2].x}, Vec3{rows[0].y, rows[1].y, rows[2].y},
             Vec3{rows[0].z, rows[1].z, rows[2].z}}};
  }
  Vec3 operator*(Vec3 v) const { return {dot(rows[0], v), dot(rows[1], v), dot(rows[2], v)}; }
  bool operator==(const Mat3&) const = default;
};

}  // namespace qray
