#include "core/guide/spatial_tree.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/support/random.h"

namespace qray {
namespace {

const Bounds3 kBounds{{-3, 0.5f, -1}, {4, 3, 2}};

Vec3 point_in(const Bounds3& b, test::Random& random) {
  const Vec3 d = b.extent();
  return b.lo + Vec3{d.x * random.next(), d.y * random.next(), d.z * random.next()};
}

// Cuts leaves at random points.
SpatialTree grown(int cuts) {
  SpatialTree tree(kBounds);
  test::Random random(3);
  for (int i = 0; i < cuts; ++i) {
    tree.split(tree.leaf_at(point_in(kBounds, random)));
    tree.index_top();
  }
  return tree;
}

TEST(SpatialTree, TheCubeHoldsTheSceneAndIsAlignedToTheWorld) {
  const SpatialTree tree(kBounds);
  const float side = std::ldexp(1.0f, tree.cube_exponent());
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_LE(tree.origin()[axis], kBounds.lo[axis]);
    EXPECT_GE(tree.origin()[axis] + side, kBounds.hi[axis]);
    EXPECT_EQ(std::fmod(tree.origin()[axis], side / 4), 0);
  }
  EXPECT_LE(side, 16);
}

TEST(SpatialTree, AWallOnABorderOfTheCubeFitsToo) {
  const SpatialTree tree({{0, 0, 0}, {4, 4, 4}});
  EXPECT_EQ(tree.cube_exponent(), 2);
  EXPECT_EQ(tree.leaf_at({4, 4, 4}), 0u);
}

TEST(SpatialTree, HalvesAlternateBetweenTheAxes) {
  SpatialTree tree({{0, 0, 0}, {4, 4, 4}});
  const uint32_t x = tree.split(0);
  tree.index_top();
  EXPECT_EQ(tree.leaf_at({1.9f, 3, 3}), x);
  EXPECT_EQ(tree.leaf_at({2.1f, 1, 1}), x + 1);
  const uint32_t y = tree.split(x);
  tree.index_top();
  EXPECT_EQ(tree.leaf_at({1, 1.9f, 3}), y);
  EXPECT_EQ(tree.leaf_at({1, 2.1f, 3}), y + 1);
  const uint32_t z = tree.split(y);
  tree.index_top();
  EXPECT_EQ(tree.leaf_at({1, 1, 2.1f}), z + 1);
  EXPECT_EQ(SpatialTree::key(tree.nodes()[z + 1], 5), (0b1001u << 3) | 5u);
}

TEST(SpatialTree, EveryPointHasTheLeafThatItsHalvesSay) {
  const SpatialTree tree = grown(3000);  // deeper than the index of the top
  test::Random random(9);
  const float side = std::ldexp(1.0f, tree.cube_exponent());
  int deepest = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 p = point_in(kBounds, random);
    Vec3 lo = tree.origin(), size{side, side, side};
    uint32_t node = 0;
    for (int depth = 0; tree.nodes()[node].child != 0; ++depth) {
      const int axis = depth % 3;
      size[axis] *= 0.5f;
      const bool upper = p[axis] >= lo[axis] + size[axis];
      if (upper) lo[axis] += size[axis];
      node = tree.nodes()[node].child + (upper ? 1u : 0u);
      deepest = std::max(deepest, depth);
    }
    ASSERT_EQ(tree.leaf_at(p), node);
  }
  EXPECT_GT(deepest, 12);
}

TEST(SpatialTree, PointsOutsideCountToTheNearestLeaf) {
  const SpatialTree tree = grown(200);
  const float side = std::ldexp(1.0f, tree.cube_exponent());
  EXPECT_EQ(tree.leaf_at(tree.origin() - Vec3{9, 9, 9}), tree.leaf_at(tree.origin()));
  const Vec3 last = tree.origin() + Vec3{side, side, side};
  EXPECT_EQ(tree.leaf_at(last + Vec3{1e9f, 1e9f, 1e9f}), tree.leaf_at(last));
}

TEST(SpatialTree, KeysOfLeavesAndFacesDiffer) {
  const SpatialTree tree = grown(500);
  std::set<uint64_t> keys;
  size_t leaves = 0;
  for (const SpatialTree::Node& node : tree.nodes()) {
    if (node.child != 0) continue;
    ++leaves;
    for (int face = 0; face < SpatialTree::kFaces; ++face)
      keys.insert(SpatialTree::key(node, face));
  }
  EXPECT_EQ(leaves, 501u);
  EXPECT_EQ(keys.size(), leaves * SpatialTree::kFaces);
}

TEST(SpatialTree, FacesAreTheNearestAxes) {
  EXPECT_EQ(SpatialTree::face_of({1, 0, 0}), 0);
  EXPECT_EQ(SpatialTree::face_of({-0.8f, 0.6f, 0}), 1);
  EXPECT_EQ(SpatialTree::face_of({0.5f, 0.7f, 0.5f}), 2);
  EXPECT_EQ(SpatialTree::face_of({0.5f, -0.7f, 0.5f}), 3);
  EXPECT_EQ(SpatialTree::face_of({0, 0.1f, 0.9f}), 4);
  EXPECT_EQ(SpatialTree::face_of({0, 0, -1}), 5);
}

}  // namespace
}  // namespace qray
