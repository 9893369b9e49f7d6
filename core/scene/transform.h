// An affine map of a mesh into the scene: scale, then rotate, then translate, or a matrix. A
// mirroring map turns the winding too, so that front faces stay in front.
#pragma once

#include <array>

#include "core/math/mat3.h"

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

  Vec3 column(size_t c) const;  // of A, or t: 3
  double determinant() const;   // of A
  Vec3 point(Vec3 p) const;
  // Of normals, which are to be made unit: the inverse transpose but for a factor, turned with the
  // winding. pre: determinant() != 0.
  Mat3 normals() const;
  bool keeps_spheres() const;  // scales alike in all directions
  // pre: the same; of a sphere, keeps_spheres().
  void apply(Mesh& mesh) const;
};

// Of a matrix by columns: 16 numbers, of which the last row is taken to be 0 0 0 1.
Transform transform_of_columns(const auto& m) {
  Transform t;
  for (size_t r = 0; r < 3; ++r)
    for (size_t c = 0; c < 4; ++c) t.rows[r][c] = m[c * 4 + r];
  return t;
}

void flip_winding(Mesh& mesh);  // normals too; a sphere's front

}  // namespace qray
