// An orthonormal frame around a unit normal: Duff et al. 2017, "Building an Orthonormal Basis,
// Revisited". Local +z is the normal.
#pragma once

#include "core/math/vec.h"

namespace qray {

struct Frame {
  Vec3 x, y, z;

  explicit Frame(Vec3 n) : z(n) {
    const float sign = std::copysign(1.0f, n.z);
    const float a = -1 / (sign + n.z);
    const float b = n.x * n.y * a;
    x = {1 + sign * sqr(n.x) * a, sign * b, -sign * n.x};
    y = {b, sign + sqr(n.y) * a, -n.y};
  }
  Frame(Vec3 x_, Vec3 y_, Vec3 z_) : x(x_), y(y_), z(z_) {}  // orthonormal, right-handed
  Vec3 to_local(Vec3 v) const { return {dot(v, x), dot(v, y), dot(v, z)}; }
  Vec3 to_world(Vec3 v) const { return x * v.x + y * v.y + z * v.z; }
};

}  // namespace qray
