#include "core/guide/direction_tree.h"

#include <gtest/gtest.h>

#include "core/math/warp.h"
#include "tests/support/random.h"

namespace qray {
namespace {

constexpr int64_t kOne = 1 << 20;

// What a bright spot around (0.8, 0.3) pays, sampled uniformly.
float paid(Vec2 u) {
  return std::abs(u.x - 0.8f) < 0.02f && std::abs(u.y - 0.3f) < 0.02f ? 50 : 0.2f;
}

// A tree grown in rounds, each of which samples from what the last one learned.
struct Grown {
  DirectionTrees trees;
  uint32_t root = 0;
  DirectionTrees::Cells cells = DirectionTrees::one_cell();
};
Grown grown(int rounds, const DirectionParams& params, int samples = 4000) {
  Grown g;
  test::Random random(5);
  DirectionTrees::adapt(g.cells, params);
  g.root = g.trees.put(g.cells);
  for (int round = 0; round < rounds; ++round) {
    for (int i = 0; i < samples; ++i) {
      float density;
      const Vec2 u = g.trees.sample(g.root, random.next_2d(), density);
      g.trees.add(g.root, u, static_cast<int64_t>(paid(u) / density * kOne));
    }
    g.cells = g.trees.take(g.root);
    DirectionTrees::estimate(g.cells, params.shrinkage);
    DirectionTrees::adapt(g.cells, params);
    g.trees.clear();
    g.root = g.trees.put(g.cells);
  }
  return g;
}

TEST(DirectionTree, TheMapOfTheDiskIsInverted) {
  test::Random random(1);
  for (int i = 0; i < 100000; ++i) {
    const Vec2 u = random.next_2d(), back = disk_to_square(square_to_disk(u));
    ASSERT_NEAR(back.x, u.x, 2e-5) << u.x << " " << u.y;
    ASSERT_NEAR(back.y, u.y, 2e-5) << u.x << " " << u.y;
  }
  for (Vec2 d : {Vec2{0, 0}, Vec2{1, 0}, Vec2{-1, 0}, Vec2{0, 1}, Vec2{0, -1}, Vec2{1.2f, 0.3f}}) {
    const Vec2 u = disk_to_square(d);
    EXPECT_TRUE(u.x >= 0 && u.x < 1 && u.y >= 0 && u.y < 1) << d.x << " " << d.y;
  }
}

TEST(DirectionTree, WithoutDataTheDensityIsOne) {
  const Grown g = grown(0, {});
  test::Random random(2);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(g.trees.pdf(g.root, random.next_2d()), 1);
}

TEST(DirectionTree, ItGrowsWhereMostArrivesAndNotElsewhere) {
  const Grown g = grown(8, {.split_share = 0.01f});
  EXPECT_GT(g.trees.pdf(g.root, {0.8f, 0.3f}), 50);
  double left_top = 0;
  test::Random random(7);
  for (int i = 0; i < 4000; ++i)
    left_top += g.trees.pdf(g.root, {random.next() / 2, 0.5f + random.next() / 2}) / 4000;
  EXPECT_NEAR(left_top, 0.2 / 0.28, 0.1);  // 0.28: what is paid in all
  uint32_t deepest = 0, deepest_dark = 0;
  // Cells in the left half hold a fifth of what arrives, spread wide.
  for (const DirectionTrees::Cell& c : g.cells) deepest = std::max(deepest, c.depth);
  for (uint32_t q : {0u, 2u}) {
    std::vector<uint32_t> open{g.cells[0].child + q};
    while (!open.empty()) {
      const DirectionTrees::Cell c = g.cells[open.back()];
      open.pop_back();
      deepest_dark = std::max(deepest_dark, c.depth);
      for (uint32_t k = 0; c.child != 0 && k < 4; ++k) open.push_back(c.child + k);
    }
  }
  EXPECT_EQ(deepest, 6u);
  EXPECT_LT(deepest_dark, 5u);
}

TEST(DirectionTree, SamplesHaveTheDensityThatIsTold) {
  const Grown g = grown(8, {});
  test::Random random(3);
  double integral = 0;
  for (int i = 0; i < 200000; ++i) {
    float density;
    const Vec2 u = g.trees.sample(g.root, random.next_2d(), density);
    ASSERT_TRUE(u.x >= 0 && u.x < 1 && u.y >= 0 && u.y < 1) << u.x << " " << u.y;
    ASSERT_NEAR(density / g.trees.pdf(g.root, u), 1, 1e-4);
    integral += g.trees.pdf(g.root, random.next_2d()) / 200000;
  }
  EXPECT_NEAR(integral, 1, 0.1);
}

TEST(DirectionTree, SamplesAtTheEdgesOfCellsStayInThem) {
  const Grown g = grown(8, {});
  const float edges[] = {0, 0x1p-24f, 0.25f, 0.5f - 0x1p-25f, 0.5f, 0.75f, kOneMinusEpsilon};
  test::Random random(6);
  for (int i = 0; i < 2000; ++i)
    for (float edge : edges)
      for (const Vec2 choice : {Vec2{edge, random.next()}, Vec2{random.next(), edge}}) {
        float density;
        const Vec2 u = g.trees.sample(g.root, choice, density);
        ASSERT_TRUE(u.x >= 0 && u.x < 1 && u.y >= 0 && u.y < 1) << choice.x << " " << choice.y;
        ASSERT_EQ(density, g.trees.pdf(g.root, u)) << choice.x << " " << choice.y;
      }
}

TEST(DirectionTree, TheSecondMomentIsTheIntegralOfTheSquaredDensity) {
  const Grown even = grown(0, {});
  EXPECT_DOUBLE_EQ(even.trees.second_moment(even.root), 1);
  DirectionTrees::Cells cells(5);
  cells[0].child = 1;
  for (uint32_t q = 1; q < 5; ++q) cells[q] = {{}, 0, 1, q == 2 ? 4.0 : 0.0};
  DirectionTrees one;
  // Chances are of 256, and none is 0: 253 of them and 3 times 1.
  EXPECT_NEAR(one.second_moment(one.put(cells)), 4 * (253 * 253 + 3) / 65536.0, 1e-6);

  const Grown g = grown(8, {});
  constexpr int kSide = 256;  // finer than the cells
  double integral = 0;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const double density =
          static_cast<double>(g.trees.pdf(g.root, {(static_cast<float>(x) + 0.5f) / kSide,
                                                   (static_cast<float>(y) + 0.5f) / kSide}));
      integral += density * density / (kSide * kSide);
    }
  EXPECT_GT(integral, 10);
  EXPECT_NEAR(g.trees.second_moment(g.root) / integral, 1, 1e-5);
}

TEST(DirectionTree, NothingIsLostWhenCellsAreCutAndJoined) {
  Grown g = grown(3, {});
  const DirectionTrees::Sums before = DirectionTrees::total(g.cells);
  DirectionParams coarse;
  coarse.split_share = 0.5f;
  for (const DirectionParams& params : {DirectionParams{}, coarse}) {
    DirectionTrees::estimate(g.cells, params.shrinkage);
    DirectionTrees::adapt(g.cells, params);
    const DirectionTrees::Sums after = DirectionTrees::total(g.cells);
    EXPECT_EQ(after.s, before.s);
    EXPECT_EQ(after.n, before.n);
  }
  EXPECT_LT(g.cells.size(), 30u);
}

TEST(DirectionTree, TakenAndPutBackItIsTheSame) {
  const Grown g = grown(6, {});
  DirectionTrees other;
  const uint32_t root = other.put(g.cells);
  const DirectionTrees::Cells cells = other.take(root);
  ASSERT_EQ(cells.size(), g.cells.size());
  const DirectionTrees::Cells first = g.trees.take(g.root);
  for (size_t i = 0; i < cells.size(); ++i) {
    EXPECT_EQ(cells[i].child, first[i].child);
    EXPECT_EQ(cells[i].depth, first[i].depth);
    EXPECT_EQ(cells[i].sums.s, first[i].sums.s);
    EXPECT_EQ(cells[i].sums.n, first[i].sums.n);
  }
}

TEST(DirectionTree, FewSamplesMoveTheEstimateLittle) {
  DirectionParams params;
  Grown g = grown(0, params);
  // One bright hit among 16 uniform ones.
  for (int i = 0; i < 16; ++i)
    g.trees.add(g.root, {(i % 4 + 0.5f) / 4, (static_cast<float>(i / 4) + 0.5f) / 4},
                i == 0 ? 16 * kOne : 0);
  DirectionTrees::Cells cells = g.trees.take(g.root);
  DirectionTrees::estimate(cells, 16);
  // Its quadrant: (16 + 16 x 1) / (4 + 16), the others 16 / 20.
  EXPECT_NEAR(cells[cells[0].child].mean / kOne, 1.6, 1e-6);
  EXPECT_NEAR(cells[cells[0].child + 3].mean / kOne, 0.8, 1e-6);
}

TEST(DirectionTree, AUniformPartBoundsWhatADarkCellWeighs) {
  Grown g = grown(6, {});
  const double before = g.trees.second_moment(g.root);
  ASSERT_GT(before, 5);
  constexpr float kPart = 0.5f;
  const double uniform = kPart / before;  // of the mean
  DirectionTrees::add_uniform(g.cells, kPart);
  g.trees.clear();
  g.root = g.trees.put(g.cells);
  // p = (f + uniform) / (1 + uniform), of which the integral of the square is known.
  const double wanted =
      (before + 2 * uniform + uniform * uniform) / ((1 + uniform) * (1 + uniform));
  EXPECT_NEAR(g.trees.second_moment(g.root), wanted, 0.02 * wanted);
  test::Random random(8);
  for (int i = 0; i < 10000; ++i)
    ASSERT_GT(g.trees.pdf(g.root, random.next_2d()),
              0.5 * uniform / (1 + uniform));  // chances are rounded
}

TEST(DirectionTree, AUniformPartLeavesATreeWithoutDataAlone) {
  DirectionTrees trees;
  DirectionTrees::Cells cells = DirectionTrees::one_cell();
  DirectionTrees::adapt(cells, {});
  DirectionTrees::add_uniform(cells, 0.5f);
  EXPECT_EQ(trees.second_moment(trees.put(cells)), 1);
}

TEST(DirectionTree, AddingIsTheSameInEitherOrderAndLosesNothing) {
  DirectionParams coarse;
  coarse.max_depth = 3;
  coarse.split_share = 0.2f;
  const Grown fine = grown(8, {}), other = grown(3, coarse, 1501);
  ASSERT_NE(fine.cells.size(), other.cells.size());
  DirectionTrees::Cells ab = fine.cells, ba = other.cells;
  DirectionTrees::add_cells(ab, other.cells);
  DirectionTrees::add_cells(ba, fine.cells);
  const DirectionTrees::Sums a = DirectionTrees::total(fine.cells),
                             b = DirectionTrees::total(other.cells);
  for (const DirectionTrees::Cells* both : {&ab, &ba}) {
    EXPECT_EQ(DirectionTrees::total(*both).s, a.s + b.s);
    EXPECT_EQ(DirectionTrees::total(*both).n, a.n + b.n);
  }
  // Cell by cell, whatever order they stand in.
  std::vector<std::pair<uint32_t, uint32_t>> open{{0, 0}};
  size_t leaves = 0, known = 0;
  while (!open.empty()) {
    const auto [i, j] = open.back();
    open.pop_back();
    const DirectionTrees::Cell &x = ab[i], &y = ba[j];
    ASSERT_EQ(x.child == 0, y.child == 0);
    ASSERT_EQ(x.depth, y.depth);
    ASSERT_EQ(x.sums.s, y.sums.s);
    ASSERT_EQ(x.sums.n, y.sums.n);
    for (uint32_t q = 0; x.child != 0 && q < 4; ++q) open.push_back({x.child + q, y.child + q});
    leaves += x.child == 0;
    known += x.child == 0 && x.sums.s > 0;
  }
  EXPECT_GE(leaves * 4, fine.cells.size() * 3);  // as fine as the finer
  EXPECT_GT(known, leaves / 2);
}

TEST(DirectionTree, ScalingRoundsTowardZeroWithoutOverflow) {
  EXPECT_EQ(DirectionTrees::scaled(1000, 179, 256), 699);
  EXPECT_EQ(DirectionTrees::scaled(int64_t{1} << 62, 179, 256), (int64_t{1} << 54) * 179);
  EXPECT_EQ(DirectionTrees::scaled(1, 1, 2), 0);
}

}  // namespace
}  // namespace qray
