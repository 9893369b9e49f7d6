// The thesis' states (section 4.3, Figure 8): a cell of a uniform grid with the face's normal. The
// grid is aligned to the world's origin and its cells are a power of two wide, so two tables of one
// scene have comparable keys. Key: 10 bits a cell coordinate, 2 x 15 bits of octahedral normal.
#pragma once

#include <cmath>
#include <cstdint>

#include "core/math/ray.h"

namespace qray {

class SurfaceGrid {
 public:
  static constexpr int kMaxGrid = 512;
  static constexpr int kKeyBits = 60;

  // About `cells` cells along the longest side of `bounds`; 1 <= cells <= kMaxGrid.
  SurfaceGrid(const Bounds3& bounds, int cells);

  struct State {
    uint64_t key = 0;
    Vec3 n;  // the key's normal, within 2e-4 of the face's: every point of the state has this one
  };
  State state_at(Vec3 p, Vec3 n) const;

  static Vec3 normal_of(uint64_t key);
  // A point: bounds that begin there and are a few cells wide have the grid of this origin_cells()
  // and of cells that are `cell` metres wide.
  static Vec3 inside_first_cell(Vec3 origin_cells, float cell);

  bool operator==(const SurfaceGrid&) const = default;
  int cell_exponent() const { return exponent_; }  // cells are 2^exponent metres wide
  float cell_m() const { return std::ldexp(1.0f, exponent_); }
  Vec3 origin_cells() const { return origin_; }  // whole numbers

 private:
  int exponent_ = 0;
  float inverse_cell_ = 1;
  Vec3 origin_;  // in cells
};

}  // namespace qray
