// Eight values side by side have the bits that each would have alone.
#include "core/math/wide.h"

#include <gtest/gtest.h>

#include "core/math/frame.h"
#include "core/math/warp.h"
#include "core/math/wide_sampler.h"

namespace qray {
namespace {

class WideTest : public testing::Test {
 protected:
  static constexpr int kRounds = 2000;
  // Fills the lanes with points of the unit square, some on its edges and in its middle.
  void draw(FloatLanes& u, FloatLanes& v) {
    for (int i = 0; i < kWidth; ++i) {
      Vec2 point = random_.next_2d();
      if (++drawn_ % 31 == 0) point.x = 0.5f;
      if (drawn_ % 37 == 0) point.y = 0.5f;
      if (drawn_ % 41 == 0) point.x = 0;
      u[i] = point.x;
      v[i] = point.y;
    }
  }
  Sampler random_{17};
  int drawn_ = 0;
};

TEST_F(WideTest, SquareToCosineHemisphere) {
  for (int round = 0; round < kRounds; ++round) {
    FloatLanes u, v;
    draw(u, v);
    Vec3Lanes d;
    d = square_to_cosine_hemisphere(u.wide(), v.wide());
    for (int i = 0; i < kWidth; ++i)
      ASSERT_EQ(d[i], square_to_cosine_hemisphere(Vec2{u[i], v[i]})) << u[i] << ", " << v[i];
  }
}

TEST_F(WideTest, DiskToSquare) {
  for (int round = 0; round < kRounds; ++round) {
    FloatLanes u, v;
    draw(u, v);
    const Wide x = 2 * u.wide() - 1, y = 2 * v.wide() - 1;  // outside of the disk, too
    Vec2Lanes of, square;
    of.x = x;
    of.y = y;
    const WideVec2 wide_square = disk_to_square(x, y);
    square.x = wide_square.x;
    square.y = wide_square.y;
    for (int i = 0; i < kWidth; ++i) ASSERT_EQ(square[i], disk_to_square(of[i])) << u[i] << v[i];
  }
}

TEST_F(WideTest, SquareToTriangle) {
  for (int round = 0; round < kRounds; ++round) {
    FloatLanes u, v, first, second;
    draw(u, v);
    const WideVec2 b = square_to_triangle(u.wide(), v.wide());
    first = b.x;
    second = b.y;
    for (int i = 0; i < kWidth; ++i)
      ASSERT_EQ((Vec2{first[i], second[i]}), square_to_triangle(Vec2{u[i], v[i]}));
  }
}

TEST_F(WideTest, FramesAndLengths) {
  for (int round = 0; round < kRounds; ++round) {
    Vec3Lanes n, v;
    for (int i = 0; i < kWidth; ++i) {
      n.set(i, square_to_uniform_sphere(random_.next_2d()));
      v.set(i, square_to_uniform_sphere(random_.next_2d()) * (1 + random_.next_2d().x));
    }
    const WideFrame wide_frame(n.wide());
    Vec3Lanes local, world, unit;
    local = wide_frame.to_local(v.wide());
    world = wide_frame.to_world(v.wide());
    unit = normalize(v.wide());
    for (int i = 0; i < kWidth; ++i) {
      const Frame frame(n[i]);
      ASSERT_EQ(local[i], frame.to_local(v[i]));
      ASSERT_EQ(world[i], frame.to_world(v[i]));
      ASSERT_EQ(unit[i], normalize(v[i]));
    }
  }
}

TEST_F(WideTest, MaxAndMinAnswerAsThoseOfOneValue) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::array<float, kWidth> a{1, 2, 0.0f, -0.0f, nan, 3, -5, 7},
      b{2, 1, -0.0f, 0.0f, 4, nan, -6, 7};
  FloatLanes wide_a, wide_b, most, least;
  for (int i = 0; i < kWidth; ++i) {
    wide_a[i] = a[static_cast<size_t>(i)];
    wide_b[i] = b[static_cast<size_t>(i)];
  }
  most = max(wide_a.wide(), wide_b.wide());
  least = min(wide_a.wide(), wide_b.wide());
  for (int i = 0; i < kWidth; ++i) {
    const float x = wide_a[i], y = wide_b[i];
    EXPECT_EQ(std::bit_cast<uint32_t>(most[i]), std::bit_cast<uint32_t>(std::max(x, y))) << i;
    EXPECT_EQ(std::bit_cast<uint32_t>(least[i]), std::bit_cast<uint32_t>(std::min(x, y))) << i;
  }
}

TEST_F(WideTest, SetsOfLanesAndMasks) {
  for (uint32_t lanes = 0; lanes <= kAllLanes; ++lanes) {
    EXPECT_EQ(lanes_of(mask_of(lanes)), lanes);
    uint32_t visited = 0;
    for_each_lane(lanes, [&](int lane) { visited |= 1u << lane; });
    EXPECT_EQ(visited, lanes);
  }
}

TEST_F(WideTest, SamplersGoOnAsEachAlone) {
  WideSampler wide_sampler;
  std::vector<Sampler> samplers;
  for (uint32_t i = 0; i < kWidth; ++i) {
    Sampler sampler(i);
    sampler.start(3 * i, 7 * i, 1000 * i);
    for (uint32_t k = 0; k < i; ++k) sampler.next_2d();
    wide_sampler.set(static_cast<int>(i), sampler);
    samplers.push_back(sampler);
  }
  for (int step = 0; step < 20; ++step) {
    WideSampler::Pairs pairs;
    wide_sampler.next_pairs(pairs);
    for (int i = 0; i < kWidth; ++i) {
      const Sampler::Pairs expected = samplers[static_cast<size_t>(i)].next_pairs();
      EXPECT_EQ(pairs.a[i], expected.a);
      EXPECT_EQ(pairs.b[i], expected.b);
      EXPECT_EQ(pairs.c[i], expected.c);
      EXPECT_EQ(pairs.d[i], expected.d);
    }
  }
}

}  // namespace
}  // namespace qray
