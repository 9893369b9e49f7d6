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

// Cuts leaves of all trees at random points.
SpatialTree grown(int cuts, int trees = 1, uint64_t seed = 3) {
  SpatialTree tree(kBounds, trees);
  test::Random random(seed);
  for (int i = 0; i < cuts; ++i) {
    tree.split(tree.leaf_at(point_in(kBounds, random), i % trees));
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
  SpatialTree tree({{0, 0, 0}, {4, 4, 4}}, SpatialTree::kFaces);
  const uint32_t first = tree.leaf_at({1, 1, 1}, 5);
  const uint32_t x = tree.split(first);
  tree.index_top();
  EXPECT_EQ(tree.leaf_at({1.9f, 3, 3}, 5), first);
  EXPECT_EQ(tree.leaf_at({2.1f, 1, 1}, 5), x);
  const uint32_t y = tree.split(first);
  tree.index_top();
  EXPECT_EQ(tree.leaf_at({1, 1.9f, 3}, 5), first);
  EXPECT_EQ(tree.leaf_at({1, 2.1f, 3}, 5), y);
  const uint32_t z = tree.split(first);
  tree.index_top();
  EXPECT_EQ(tree.leaf_at({1, 1, 2.1f}, 5), z);
  EXPECT_EQ(tree.key(z), (0b1001u << 3) | 5u);
  EXPECT_EQ(tree.depth(z), 3);
  EXPECT_EQ(tree.extent(z), (Vec3{2, 2, 2}));
  EXPECT_EQ(tree.extent(y), (Vec3{2, 2, 4}));
  EXPECT_EQ(tree.leaf_at({1, 1, 2.1f}, 4), 4u) << "the other trees are as they were";
}

TEST(SpatialTree, EveryPointHasTheLeafThatItsHalvesSay) {
  const SpatialTree tree = grown(3000, 2);  // deeper than the index of the top
  test::Random random(9);
  const float side = std::ldexp(1.0f, tree.cube_exponent());
  int deepest = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 p = point_in(kBounds, random);
    const uint32_t leaf = tree.leaf_at(p, i % 2);
    Vec3 lo = tree.origin(), size{side, side, side};
    uint64_t halves = 1;
    for (int depth = 0; depth < tree.depth(leaf); ++depth) {
      const int axis = depth % 3;
      size[axis] *= 0.5f;
      const bool upper = p[axis] >= lo[axis] + size[axis];
      if (upper) lo[axis] += size[axis];
      halves = halves << 1 | upper;
    }
    ASSERT_EQ(tree.key(leaf), halves << 3 | static_cast<uint64_t>(i % 2));
    ASSERT_EQ(tree.extent(leaf), size);
    deepest = std::max(deepest, tree.depth(leaf));
  }
  EXPECT_GT(deepest, 12);
}

TEST(SpatialTree, TheSecondHalfIsWhereACutTakesThePoint) {
  SpatialTree tree = grown(300, 6);
  test::Random random(4);
  int seconds = 0;
  for (int i = 0; i < 1000; ++i) {
    const Vec3 p = point_in(kBounds, random);
    const uint32_t leaf = tree.leaf_at(p, i % 6);
    const bool second = tree.in_upper_half(p, leaf);
    const uint32_t made = tree.split(leaf);
    tree.index_top();
    ASSERT_EQ(tree.leaf_at(p, i % 6), second ? made : leaf);
    seconds += second;
  }
  EXPECT_GT(seconds, 300);
  EXPECT_LT(seconds, 700);
}

TEST(SpatialTree, ASurfaceInThePlaneOfACutIsInOneLeafASide) {
  SpatialTree tree({{0, 0, 0}, {4, 4, 4}});
  for (int cut = 0; cut < 6; ++cut) {  // planes at 1 and 2 for y
    for (uint32_t leaf = 0, leaves = static_cast<uint32_t>(tree.leaves()); leaf < leaves; ++leaf)
      tree.split(leaf);
    tree.index_top();
  }
  const Vec3 up{0, 1, 0};
  for (float y : {1.0f, 2.0f, 3.0f}) {
    const float above = std::nextafter(y, 9.0f), below = std::nextafter(y, 0.0f);
    ASSERT_NE(tree.leaf_at({1.5f, above, 1.5f}), tree.leaf_at({1.5f, below, 1.5f}));
    for (const Vec3 n : {up, -up}) {
      const auto leaf = [&](float at) { return tree.leaf_at(tree.beside({1.5f, at, 1.5f}, n)); };
      EXPECT_EQ(leaf(above), leaf(y));
      EXPECT_EQ(leaf(below), leaf(y));
      EXPECT_EQ(leaf(y), tree.leaf_at(Vec3{1.5f, y, 1.5f} + n * 0.1f));
    }
  }
}

TEST(SpatialTree, AKeyReachesItsLeafAndCutsIt) {
  const SpatialTree fine = grown(500, 3);
  SpatialTree tree(kBounds, 3);
  std::set<uint64_t> keys;
  for (uint32_t leaf = 0; leaf < fine.leaves(); ++leaf) {
    const uint64_t key = fine.key(leaf);
    keys.insert(key);
    EXPECT_TRUE(SpatialTree::valid_key(key, 3));
    const uint32_t reached = tree.reach(key);
    ASSERT_NE(reached, SpatialTree::kNone);
    ASSERT_EQ(tree.key(reached), key);
    ASSERT_EQ(tree.reach(key), reached) << "once more, and nothing is cut";
  }
  tree.index_top();
  ASSERT_EQ(tree.leaves(), fine.leaves());
  test::Random random(8);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 p = point_in(kBounds, random);
    ASSERT_EQ(tree.key(tree.leaf_at(p, i % 3)), fine.key(fine.leaf_at(p, i % 3)));
  }
  // Keys of places that were cut since.
  for (uint64_t key : keys) {
    const uint64_t parent = key >> 4 << 3 | (key & 7);
    EXPECT_EQ(tree.reach(parent), SpatialTree::kNone);
    EXPECT_EQ(tree.leaf_with(parent), SpatialTree::kNone);
  }
  EXPECT_EQ(tree.leaves(), fine.leaves());
}

TEST(SpatialTree, TheLeafWithAFinerKeyHoldsAllOfIt) {
  const SpatialTree coarse = grown(60, 2), fine = grown(900, 2);  // the same first cuts
  test::Random random(2);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p = point_in(kBounds, random);
    const uint32_t small = fine.leaf_at(p, i % 2), large = coarse.leaf_at(p, i % 2);
    ASSERT_EQ(coarse.leaf_with(fine.key(small)), large);
    ASSERT_EQ(fine.leaf_with(fine.key(small)), small);
  }
}

TEST(SpatialTree, KeysOfNoPlaceAreNotValid) {
  EXPECT_FALSE(SpatialTree::valid_key(0, 6)) << "no leading 1";
  EXPECT_FALSE(SpatialTree::valid_key(7, 6)) << "no leading 1";
  EXPECT_TRUE(SpatialTree::valid_key(8, 6));
  EXPECT_TRUE(SpatialTree::valid_key(8 + 5, 6));
  EXPECT_FALSE(SpatialTree::valid_key(8 + 6, 6));
  EXPECT_FALSE(SpatialTree::valid_key(8 + 1, 1));
  constexpr uint64_t kDeepest = uint64_t{1} << (SpatialTree::kMaxDepth + 3);
  EXPECT_TRUE(SpatialTree::valid_key(kDeepest, 1));
  EXPECT_FALSE(SpatialTree::valid_key(kDeepest << 1, 1));
}

TEST(SpatialTree, PointsOutsideCountToTheNearestLeaf) {
  const SpatialTree tree = grown(200);
  const float side = std::ldexp(1.0f, tree.cube_exponent());
  EXPECT_EQ(tree.leaf_at(tree.origin() - Vec3{9, 9, 9}), tree.leaf_at(tree.origin()));
  const Vec3 last = tree.origin() + Vec3{side, side, side};
  EXPECT_EQ(tree.leaf_at(last + Vec3{1e9f, 1e9f, 1e9f}), tree.leaf_at(last));
}

TEST(SpatialTree, KeysOfLeavesAndTreesDiffer) {
  const SpatialTree tree = grown(500, SpatialTree::kFaces);
  ASSERT_EQ(tree.leaves(), 500u + SpatialTree::kFaces);
  std::set<uint64_t> keys;
  for (uint32_t leaf = 0; leaf < tree.leaves(); ++leaf) keys.insert(tree.key(leaf));
  EXPECT_EQ(keys.size(), tree.leaves());
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
