// The environment as a light: looked up with bilinear interpolation, and sampled by a density in
// proportion to sin(theta) times what luminance exceeds its mean: the rest is left to the sampling
// of surfaces, which finds what comes from everywhere, so this must be combined with it (Karlik et
// al. 2019, "MIS Compensation"). An even environment is left to it altogether: there is no density
// of directions then. Tiles of a large picture are picked by a table that stays in the
// cache. Where a tile is even, its directions are alike; elsewhere the density is bilinear between
// the same texels as the picture, and light at the poles, where rows shrink to a point, is neither
// missed nor overdone. 4 bytes a texel beside the picture, at most. Immutable; any thread.
#pragma once

#include <algorithm>
#include <vector>

#include "core/math/distribution.h"
#include "core/scene/scene.h"

namespace qray {

class EnvironmentLight {
 public:
  explicit EnvironmentLight(const Environment& environment);  // which outlives this

  struct Sample {
    Vec3 wi;          // unit, world
    float pdf_w = 0;  // 0: no light there
    Rgb radiance;     // that arrives from there
  };
  // `normal`: directions behind the surface are not wanted, and may come with pdf_w = 0; zero: all
  // are.
  Sample sample(Vec2 u, Vec3 normal = {}) const { return sample_of(draw(u, normal)); }
  // The same in steps, of which each asks memory for what the next one reads: many directions may
  // be drawn at once before any of them waits.
  struct Drawn {
    int column = 0, row = -1;  // of a tile; -1: no light there
    Vec2 offset;               // in the tile, 0..1, of its weight above and to the left
    float of_cell = 1;         // the chance of the cell whose directions are drawn from
    bool exists() const { return row >= 0; }
  };
  Drawn draw(Vec2 u, Vec3 normal = {}) const;
  void prefetch_tile(const Drawn& drawn) const;
  void prefetch_picture(const Drawn& drawn) const;
  Sample sample_of(const Drawn& drawn) const;
  // What arrives from there, and the density with which sample() makes it.
  struct Arriving {
    Rgb radiance;
    float pdf_w = 0;
  };
  Arriving at(Vec3 wi) const;

  // The same by cells: 8 rows of 16, of about as much height and width each. sample() picks each
  // with its chance.
  static constexpr uint32_t kCellRows = 8, kCellColumns = 16, kCells = kCellRows * kCellColumns;
  float cell_chance(uint32_t cell) const;
  // pdf_w: of the cell's directions alone
  Sample sample_in(uint32_t cell, Vec2 u, Vec3 normal = {}) const {
    return sample_of(draw_in(cell, u, normal));
  }
  Drawn draw_in(uint32_t cell, Vec2 u, Vec3 normal = {}) const;
  struct InCell {
    Rgb radiance;
    float pdf_w = 0;  // of sample_in() for this cell
    uint32_t cell = 0;
  };
  InCell in_cell(Vec3 wi) const;
  float pdf_w(Vec3 wi) const { return at(wi).pdf_w; }
  Rgb radiance(Vec3 wi) const;
  float mean_luminance() const { return mean_luminance_; }
  float brightest() const;  // luminance of any direction
  // Hardly brighter in some directions than in others: the density is 0 everywhere, sample() and
  // the cells are not there.
  bool even() const { return row_cdf_.empty(); }

 private:
  // A position between four nodes. Nodes are texel centres, and a row more at each pole: cells in
  // row 0 and in the last one reach from the pole to the nearest centres.
  struct Place {
    int column, row;  // of the cell
    Vec2 offset;      // in it, 0..1
    float sin_theta;
  };
  // The four texels about it, and the density's nodes there.
  struct Corners {
    Rgb c00, c10, c01, c11;
    float n00, n10, n01, n11;
  };
  Place place(Vec3 wi) const;
  Corners corners(int column, int row) const;
  float node(Rgb texel, int row) const {
    return std::max(luminance(texel) - left_out_, 0.0f) * row_sine_[static_cast<size_t>(row)];
  }
  // Cells that are picked together: columns and rows [begin, end).
  struct Tile {
    int column, column_end, row, row_end;
    size_t index;   // row by row
    size_t in_cdf;  // of tile_cdf_
    int cells() const { return (column_end - column) * (row_end - row); }
  };
  Tile tile(int tile_column, int tile_row) const;
  float add_tile(const Tile& tile);  // to blocks_; returns its weight
  Place place_in(const Tile& tile, Vec2 offset) const;
  float pdf_w(const Place& place, const Tile& tile, const Corners& corners) const;
  Drawn draw_in_tile(CdfPick row, CdfPick column, Vec3 normal) const;
  void fill_centers();
  bool is_behind(int tile_column, int tile_row, Vec3 normal) const;
  struct CellTiles {
    int row, row_end, column, column_end;
  };
  CellTiles tiles_of(uint32_t cell) const;
  uint32_t cell_of(int tile_column, int tile_row) const;
  void fill_cells();
  float cell_probability(const Tile& tile, const Place& place) const;  // of the tile's
  Rgb radiance(const Place& place, const Corners& corners) const;

  static constexpr uint32_t kEven = ~0u;
  const Environment& environment_;
  int width_, height_;                                // texels; 0: constant
  std::vector<float> row_sine_;                       // of each row of nodes
  int shift_ = 0, tile_columns_ = 0, tile_rows_ = 0;  // a tile has 2^shift cells on a side
  std::vector<float> row_cdf_, tile_cdf_;             // of rows of tiles, and of tiles in each
  std::vector<uint32_t> row_guide_, tile_guide_;
  std::vector<float> cell_rows_;         // of each cell in turn, sums of chances by row of tiles
  std::vector<uint32_t> cell_begin_{0};  // where they begin, and the end
  size_t guide_size_ = 0;                // of a row
  // Of a tile that is not even: running sums of its cells' weights over all, row by row.
  std::vector<uint32_t> block_of_tile_;  // where they begin, in squares of the side; or kEven
  std::vector<float> blocks_;
  // Where tiles have their middle: sines and cosines of theta by row, of phi by column. No
  // direction in a tile is farther from it than by this sine, 2: than a right angle.
  std::vector<Vec2> row_centers_, column_centers_;
  float tile_reach_ = 2;
  float mean_luminance_ = 0;
  float left_out_ = 0;  // of each texel's luminance, by the density
};

}  // namespace qray
