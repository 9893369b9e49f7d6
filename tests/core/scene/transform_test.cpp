#include "core/scene/transform.h"

#include <gtest/gtest.h>

#include "core/import/primitives.h"
#include "tests/support/near.h"

namespace qray {
namespace {

using test::expect_near;

Vec3 front(const Mesh& mesh, size_t triangle) {
  const auto& t = mesh.triangles[triangle];
  const Vec3 p = mesh.positions[t[0]];
  return normalize(cross(mesh.positions[t[1]] - p, mesh.positions[t[2]] - p));
}

// Volume by the divergence theorem: positive when all fronts face outward.
double volume(const Mesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles)
    sum += dot(mesh.positions[t[0]], cross(mesh.positions[t[1]], mesh.positions[t[2]])) / 6;
  return sum;
}

TEST(Transform, RotationIsCounterClockwiseSeenFromTheAxis) {
  Mesh mesh = make_quad({0, 0, 0}, {1, 0, 0}, {0, 0, 1});
  Transform::rotation({0, 2, 0}, 90).apply(mesh);
  expect_near(mesh.positions[1], {0, 0, -1});
  expect_near(mesh.positions[3], {1, 0, 0});
}

TEST(Transform, AfterAppliesTheOtherFirst) {
  Mesh mesh = make_quad({1, 0, 0}, {1, 0, 0}, {0, 1, 0});
  Transform::translation({0, 0, 5}).after(Transform::scaling({2, 3, 4})).apply(mesh);
  expect_near(mesh.positions[0], {2, 0, 5});
  expect_near(mesh.positions[2], {4, 3, 5});
}

TEST(Transform, MirroringKeepsFrontsOutward) {
  for (const Vec3 factors : {Vec3{-1, 1, 1}, Vec3{1, -2, 1}, Vec3{-1, -1, -3}, Vec3{-1, -1, 1}}) {
    Mesh mesh = make_sphere({0.3f, 0, 0}, 1, 1);
    const double before = volume(mesh);
    Transform::scaling(factors).apply(mesh);
    EXPECT_NEAR(volume(mesh), before * std::abs(factors.x * factors.y * factors.z), 1e-3);
    for (size_t i = 0; i < mesh.triangles.size(); ++i)
      EXPECT_GT(dot(front(mesh, i), mesh.normals[mesh.triangles[i][0]]), 0.5f);
  }
}

TEST(Transform, NormalsStayPerpendicularUnderUnevenScale) {
  Mesh mesh = make_quad({0, 0, 0}, {1, 1, 0}, {0, 0, -1});
  mesh.normals.assign(4, front(mesh, 0));
  Transform::scaling({5, 0.5f, 2}).after(Transform::rotation({1, 2, 3}, 40)).apply(mesh);
  for (const Vec3 n : mesh.normals) expect_near(n, front(mesh, 0));
}

TEST(Transform, FlipTurnsWindingAndNormals) {
  Mesh mesh = make_sphere({0, 0, 0}, 1, 0);
  const double before = volume(mesh);
  const Vec3 normal = mesh.normals[0];
  flip_winding(mesh);
  EXPECT_NEAR(volume(mesh), -before, 1e-6);
  expect_near(mesh.normals[0], -normal);
}

TEST(Primitives, ClosedShapesHaveTheirVolumeAndUnitNormals) {
  const struct {
    const char* name;
    Mesh mesh;
    double volume;
  } cases[] = {
      {"box", make_box({-1, 0, 2}, {1, 3, 2.5f}), 3},
      {"sphere", make_sphere({1, 2, 3}, 0.5f, 5), 4.0 / 3 * kPi / 8},
      {"cylinder", make_cylinder({5, 0, 0}, 2, 0.5f, 0.5f, 256, true), kPi / 2},
      {"frustum", make_cylinder({0, 1, 0}, 3, 1, 0.5f, 256, true), kPi * (1 + 0.5 + 0.25)},
  };
  for (const auto& c : cases) {
    EXPECT_NEAR(volume(c.mesh), c.volume, 2e-3 * c.volume) << c.name;
    for (const Vec3 n : c.mesh.normals) EXPECT_NEAR(length(n), 1, 1e-5f) << c.name;
    for (size_t i = 0; i < c.mesh.triangles.size() && !c.mesh.normals.empty(); ++i)
      EXPECT_GT(dot(front(c.mesh, i), c.mesh.normals[c.mesh.triangles[i][2]]), 0.9f) << c.name;
  }
}

TEST(Primitives, FlatShapesFaceTheirNormal) {
  expect_near(front(make_quad({0, 0, 0}, {0, 0, 1}, {1, 0, 0}), 1), {0, 1, 0});
  const Mesh disk = make_disk({1, 1, 1}, {0, -3, 0}, 2, 64);
  for (size_t i = 0; i < disk.triangles.size(); ++i) expect_near(front(disk, i), {0, -1, 0});
  EXPECT_EQ(disk.triangles.size(), 64u);
  EXPECT_EQ(make_sphere({}, 1, 3).triangles.size(), 20u * 64);
}

}  // namespace
}  // namespace qray
