#include "core/guide/surface_grid.h"

#include <gtest/gtest.h>

#include "core/math/hash.h"
#include "core/math/warp.h"

namespace qray {
namespace {

Bounds3 unit_box() { return {{0, 0, 0}, {1, 1, 1}}; }

TEST(SurfaceGrid, KeepsNormalsWithinRounding) {
  const SurfaceGrid grid(unit_box(), 16);
  for (uint64_t i = 0; i < 10'000; ++i) {
    const uint64_t h = mix64(i);
    const Vec3 n = square_to_uniform_sphere(
        {to_unit_float(static_cast<uint32_t>(h)), to_unit_float(static_cast<uint32_t>(h >> 32))});
    EXPECT_LT(length(grid.state_at({0.5f, 0.5f, 0.5f}, n).n - n), 2e-4f);
  }
}

TEST(SurfaceGrid, AxisNormalsAreExact) {
  const SurfaceGrid grid(unit_box(), 16);
  for (Vec3 n : {Vec3{1, 0, 0}, Vec3{-1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, -1, 0}, Vec3{0, 0, 1},
                 Vec3{0, 0, -1}})
    EXPECT_EQ(grid.state_at({0.5f, 0.5f, 0.5f}, n).n, n);
}

TEST(SurfaceGrid, RoundingNoiseDoesNotSplitWallsAtRoundCoordinates) {
  const SurfaceGrid grid({{-2, 0, -2}, {2, 4, 2}}, 32);
  for (int i = -32; i <= 32; ++i) {
    const float wall = static_cast<float>(i) / 16;
    const uint64_t a = grid.state_at({wall * (1 - 1e-6f) - 1e-7f, 1, 1}, {1, 0, 0}).key;
    const uint64_t b = grid.state_at({wall * (1 + 1e-6f) + 1e-7f, 1, 1}, {1, 0, 0}).key;
    EXPECT_EQ(a, b) << wall;
  }
}

TEST(SurfaceGrid, CellsAndSidesAreStatesOfTheirOwn) {
  const SurfaceGrid grid(unit_box(), 16);
  const Vec3 p{0.3f, 0.4f, 0.5f}, n{0, 0, 1};
  EXPECT_NE(grid.state_at(p, n).key, grid.state_at(p, -n).key);
  const float cell = std::ldexp(1.0f, grid.cell_exponent());
  EXPECT_EQ(cell, 0.0625f);
  EXPECT_NE(grid.state_at(p, n).key, grid.state_at(p + Vec3{cell, 0, 0}, n).key);
}

TEST(SurfaceGrid, TwoGridsOverOneSceneAgreeOnKeys) {
  const SurfaceGrid a(unit_box(), 16), b(unit_box(), 17);
  EXPECT_EQ(a.state_at({0.1f, 0.9f, 0.2f}, {0, 1, 0}).key,
            b.state_at({0.1f, 0.9f, 0.2f}, {0, 1, 0}).key);
}

}  // namespace
}  // namespace qray
