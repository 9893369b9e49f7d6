#include "core/scene/transform.h"

#include "core/scene/scene.h"

namespace qray {

Transform Transform::rotation(Vec3 axis, float deg) {
  // Rodrigues' formula.
  const double angle = static_cast<double>(deg) * std::numbers::pi / 180;
  const double c = std::cos(angle), s = std::sin(angle);
  const double norm = std::hypot(axis.x, axis.y, axis.z);
  const double x = axis.x / norm, y = axis.y / norm, z = axis.z / norm;
  Transform t;
  t.rows = {{{c + x * x * (1 - c), x * y * (1 - c) - z * s, x * z * (1 - c) + y * s, 0},
             {y * x * (1 - c) + z * s, c + y * y * (1 - c), y * z * (1 - c) - x * s, 0},
             {z * x * (1 - c) - y * s, z * y * (1 - c) + x * s, c + z * z * (1 - c), 0}}};
  return t;
}

Transform Transform::scaling(Vec3 factors) {
  Transform t;
  for (int i = 0; i < 3; ++i) t.rows[i][i] = factors[i];
  return t;
}

Transform Transform::translation(Vec3 offset) {
  Transform t;
  for (int i = 0; i < 3; ++i) t.rows[i][3] = offset[i];
  return t;
}

Transform Transform::after(const Transform& first) const {
  Transform out;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 4; ++c) {
      out.rows[r][c] = c == 3 ? rows[r][3] : 0;
      for (int k = 0; k < 3; ++k) out.rows[r][c] += rows[r][k] * first.rows[k][c];
    }
  }
  return out;
}

Vec3 Transform::column(size_t c) const {
  return {static_cast<float>(rows[0][c]), static_cast<float>(rows[1][c]),
          static_cast<float>(rows[2][c])};
}

double Transform::determinant() const {
  const auto& a = rows;
  return a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) -
         a[0][1] * (a[1][0] * a[2][2] - a[1][2] * a[2][0]) +
         a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0]);
}

Vec3 Transform::point(Vec3 p) const {
  Vec3 out;
  for (int r = 0; r < 3; ++r)
    out[r] =
        static_cast<float>(rows[r][0] * p.x + rows[r][1] * p.y + rows[r][2] * p.z + rows[r][3]);
  return out;
}

Mat3 Transform::normals() const {
  // The cofactors, with the determinant's sign.
  const auto& a = rows;
  double m[3][3], largest = 0;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      const int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
      m[r][c] = a[r1][c1] * a[r2][c2] - a[r1][c2] * a[r2][c1];
      largest = std::max(largest, std::abs(m[r][c]));
    }
  }
  const double scale = (determinant() < 0 ? -1 : 1) / largest;  // floats hold no squares of squares
  Mat3 out;
  for (size_t r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) out.rows[r][c] = static_cast<float>(m[r][c] * scale);
  return out;
}

bool Transform::keeps_spheres() const {
  constexpr double kSlack = 1e-4;
  double columns[3][3] = {};  // their products
  for (size_t i = 0; i < 3; ++i)
    for (size_t j = 0; j < 3; ++j)
      for (const auto& row : rows) columns[i][j] += row[i] * row[j];
  for (size_t i = 0; i < 3; ++i)
    for (size_t j = 0; j < 3; ++j)
      if (!(std::abs(columns[i][j] - (i == j ? columns[0][0] : 0)) <= kSlack * columns[0][0]))
        return false;
  return true;
}

void Transform::apply(Mesh& mesh) const {
  if (mesh.sphere) {
    Sphere& s = *mesh.sphere;
    const double scale = std::cbrt(std::abs(determinant()));
    s.center = point(s.center);
    s.radius *= static_cast<float>(scale);
    // New rows: those of the old, turned along.
    for (Vec3& row : s.to_local.rows) {
      Vec3 turned;
      for (int r = 0; r < 3; ++r)
        turned[r] = static_cast<float>((rows[static_cast<size_t>(r)][0] * row.x +
                                        rows[static_cast<size_t>(r)][1] * row.y +
                                        rows[static_cast<size_t>(r)][2] * row.z) /
                                       scale);
      row = turned;
    }
  }
  for (Vec3& p : mesh.positions) p = point(p);
  const Mat3 to_world = normals();
  for (Vec3& n : mesh.normals) n = normalize(to_world * n);
  if (determinant() < 0)
    for (auto& tri : mesh.triangles) std::swap(tri[1], tri[2]);
}

void flip_winding(Mesh& mesh) {
  for (auto& tri : mesh.triangles) std::swap(tri[1], tri[2]);
  for (Vec3& n : mesh.normals) n = -n;
  if (mesh.sphere) mesh.sphere->inward = !mesh.sphere->inward;
}

}  // namespace qray
