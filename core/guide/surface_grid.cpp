#include "core/guide/surface_grid.h"

#include <algorithm>
#include <cmath>

namespace qray {
namespace {

// Walls often stand at round coordinates. Shifting the grid by an odd part of a cell keeps rounding
// noise from tossing their points between two cells.
constexpr float kShift = 0.381966f;
constexpr int kAxisMax = 1023;
constexpr float kNormalSteps = 32766;  // even, so that 0 is a step and axis-aligned normals exact

uint32_t quantize(float v) {
  const float unit = std::clamp(v * 0.5f + 0.5f, 0.0f, 1.0f);
  return static_cast<uint32_t>(unit * kNormalSteps + 0.5f);
}

// Octahedral coordinates of a unit vector (Cigolle et al. 2014).
uint32_t encode_normal(Vec3 n) {
  const float inverse = 1 / (std::abs(n.x) + std::abs(n.y) + std::abs(n.z));
  float x = n.x * inverse, y = n.y * inverse;
  if (n.z < 0) {
    const float fold_x = std::copysign(1 - std::abs(y), x);
    y = std::copysign(1 - std::abs(x), y);
    x = fold_x;
  }
  return quantize(x) << 15 | quantize(y);
}

float dequantize(uint32_t v) { return static_cast<float>(v) / kNormalSteps * 2 - 1; }

}  // namespace

SurfaceGrid::SurfaceGrid(const Bounds3& bounds, int cells) {
  const Vec3 extent = bounds.extent();
  const float longest = std::max({extent.x, extent.y, extent.z, 1e-30f});
  exponent_ = static_cast<int>(std::lround(std::log2(longest / static_cast<float>(cells))));
  inverse_cell_ = std::ldexp(1.0f, -exponent_);
  const auto floor_cell = [&](float v) { return std::floor(v * inverse_cell_ + kShift) - 1; };
  origin_ = {floor_cell(bounds.lo.x), floor_cell(bounds.lo.y), floor_cell(bounds.lo.z)};
}

SurfaceGrid::State SurfaceGrid::state_at(Vec3 p, Vec3 n) const {
  const auto cell = [&](float v, float origin) {
    const float c = std::floor(v * inverse_cell_ + kShift) - origin;
    return static_cast<uint64_t>(std::clamp(c, 0.0f, static_cast<float>(kAxisMax)));
  };
  State s;
  s.key = cell(p.x, origin_.x) << 50 | cell(p.y, origin_.y) << 40 | cell(p.z, origin_.z) << 30 |
          encode_normal(n);
  s.n = normal_of(s.key);
  return s;
}

Vec3 SurfaceGrid::inside_first_cell(Vec3 origin_cells, float cell) {
  const float half = 1.5f - kShift;  // the bounds' first cell is the grid's second
  return (origin_cells + Vec3{half, half, half}) * cell;
}

Vec3 SurfaceGrid::normal_of(uint64_t key) {
  float x = dequantize(static_cast<uint32_t>(key >> 15 & 0x7fff));
  float y = dequantize(static_cast<uint32_t>(key & 0x7fff));
  const float z = 1 - std::abs(x) - std::abs(y);
  if (z < 0) {
    const float fold_x = std::copysign(1 - std::abs(y), x);
    y = std::copysign(1 - std::abs(x), y);
    x = fold_x;
  }
  return normalize(Vec3{x, y, z});
}

}  // namespace qray
