// What the loops of the pyramid read and write. Plain data, borrowed for the call.
#pragma once

#include <cstddef>

#include "core/recover/pyramid.h"

namespace qray {

// Numbers of cells, interleaved, with room for a border of one cell around: of zeros, where a layer
// looks at neighbours.
struct CellGrid {
  float* first = nullptr;  // of cell (0, 0)
  std::ptrdiff_t row = 0;  // floats
  int height = 0, width = 0, channels = 0;

  float* at(int y, int x) const {
    return first + y * row + static_cast<std::ptrdiff_t>(x) * channels;
  }
};

// Numbers of cells, each row's planes one after the other, with room for a cell on the left and 17
// on the right; those that vectors of the row reach are copies of the edge.
struct CellPlanes {
  float* first = nullptr;
  std::ptrdiff_t pitch = 0;  // floats from plane to plane of a row
  int height = 0, width = 0, count = 0;

  float* at(int k, int y) const {
    return first + (static_cast<std::ptrdiff_t>(y) * count + k) * pitch;
  }
};

// A row of cells to be filtered.
struct FilterRow {
  int y = 0;
  CellPlanes colour, features;  // of this level
  // The two nearest rows of the coarser level, each cell twice: its result and features. Null at
  // the coarsest level.
  const float *coarse_colour[2] = {}, *coarse_features[2] = {};
  std::ptrdiff_t pitch = 0;       // of these and of all that follows, from plane to plane
  const float* logits = nullptr;  // kPyramidTaps planes
  const float* scales = nullptr;  // 2 x kDistances, not logarithms
  float* out = nullptr;           // kColour planes
  float* kernels = nullptr;       // kPyramidTaps planes, or null: not kept
};

struct BackFilterRow {
  FilterRow forward;               // with its kernels; `out` and `logits` are not used
  const float* d_out = nullptr;    // kColour planes
  CellPlanes d_colour;             // added to
  float* d_coarse_colour[2] = {};  // added to
  float* d_logits = nullptr;       // kPyramidTaps planes, written
  double* d_scales = nullptr;      // 2 x kDistances, added to: by the scales themselves
};

struct PyramidLoops {
  // out = leaky(bias + in * weights), a row of it; bias may be null.
  void (*convolve_row)(const CellGrid& in, const PyramidLayer& layer, const float* weights,
                       const float* bias, float slope, const CellGrid& out, int y);
  // Adds what d_out, the gradient before the leaky unit, makes of a layer's weights and biases.
  void (*add_weight_gradient)(const CellGrid& in, const PyramidLayer& layer, const CellGrid& d_out,
                              float* d_weights, float* d_bias);
  void (*filter_row)(const FilterRow& row);
  void (*back_filter_row)(const BackFilterRow& row);
};

const PyramidLoops& common_pyramid_loops();  // for what the project is compiled for
const PyramidLoops& avx512_pyramid_loops();  // only where has_avx512()

}  // namespace qray
