// An affine map of a mesh into the scene: scale, then rotate, then translate, or a matrix. A
// mirroring map turns the winding too, so that front faces stay in front.
#pragma once

#include <array>

#include "core/math/vec.h"

namespace qray {

struct Mesh;

struct Transform {
  // Rows of [A | t].
  std::array<std::array<double, 4>, 3> rows{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};

  // Counter-clockwise seen from the axis' tip; `axis` need not be unit, but not zero.
  static Transform rotation(Vec3 axis, float deg);
  static Transform scaling(Vec3 factors);
  static Transform translation(Vec3 offset);
  Transform after(const Transform& first) const;  // the map: first, then this

  double determinant() const;    // of A
  void apply(Mesh& mesh) const;  // pre: determinant() != 0
};

void flip_winding(Mesh& mesh);  // normals too

}  // namespace qray
