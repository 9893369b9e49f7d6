// An exact sphere, in place of a mesh's triangles. Directions are world space and unit.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/math/mat3.h"
#include "core/math/ray.h"
#include "core/math/warp.h"

namespace qray {

struct Sphere {
  Vec3 center;
  float radius = 1;     // metres
  bool inward = false;  // its front is the inside
  // Turns outward normals to where the poles are at +-z: a rotation, perhaps with a mirroring.
  Mat3 to_local;

  bool operator==(const Sphere&) const = default;

  Bounds3 bounds() const {
    const Vec3 r{radius, radius, radius};
    Bounds3 box;
    box.add(center - r);
    box.add(center + r);
    return box;
  }
  // u around the poles from 0 to 1, v from 0 at -z to 1 at +z.
  Vec2 uv(Vec3 outward) const {
    const Vec3 n = to_local * outward;
    const float turn = angle_of(n.y, n.x) / (2 * kPi);
    return {turn < 0 ? turn + 1 : turn, 1 - std::acos(std::clamp(n.z, -1.0f, 1.0f)) / kPi};
  }
  // Where u and v grow to at that place, metres a unit of them. At the poles u grows nowhere.
  struct Tangents {
    Vec3 du, dv;
  };
  Tangents tangents(Vec3 outward) const {
    const Vec3 n = to_local * outward;
    const float r = std::hypot(n.x, n.y);
    const Vec3 along_v = r > 0 ? Vec3{-n.z * n.x / r, -n.z * n.y / r, r} : Vec3{1, 0, 0};
    const Mat3 to_world = to_local.transposed();
    return {to_world * Vec3{-n.y, n.x, 0} * (2 * kPi * radius),
            to_world * along_v * (kPi * radius)};
  }
};

}  // namespace qray
