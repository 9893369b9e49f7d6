// The environment as a light: looked up with bilinear interpolation, and sampled by a density that
// is bilinear between the same texels, in proportion to luminance times sin(theta) at each; so it
// is positive exactly where the picture is, and light at the poles, where rows shrink to a point,
// is neither missed nor overdone. 4 bytes a texel beside the picture. Immutable; any thread.
#pragma once

#include <vector>

#include "core/scene/scene.h"

namespace qray {

class EnvironmentLight {
 public:
  explicit EnvironmentLight(const Environment& environment);  // which outlives this

  struct Sample {
    Vec3 wi;          // unit, world
    float pdf_w = 0;  // 0: no light anywhere
  };
  Sample sample(Vec2 u) const;
  float pdf_w(Vec3 wi) const;
  Rgb radiance(Vec3 wi) const;  // that arrives from there
  float mean_luminance() const { return mean_luminance_; }
  float brightest() const;  // luminance of any direction

 private:
  // A position between four nodes. Nodes are texel centres, and a row more at each pole: cells in
  // row 0 and in the last one reach from the pole to the nearest centres.
  struct Place {
    int column, row;  // of the cell
    Vec2 offset;      // in it, 0..1
    float sin_theta;
  };
  Place place(Vec3 wi) const;
  float node(int column, int row) const;  // luminance times sin(theta)
  float cell_weight(int column, int row) const;
  float pdf_w(const Place& place) const;

  const Environment& environment_;
  int width_, height_;           // texels; 0: constant
  std::vector<float> row_sine_;  // of each row of nodes
  std::vector<float> row_cdf_;   // of cells: height + 2
  std::vector<float> cell_cdf_;  // height + 1 rows of width + 1
  float mean_luminance_ = 0;
};

}  // namespace qray
