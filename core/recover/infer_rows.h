// What FastRecovery's loops read and write. Plain data; rows of one stage may run in any order and
// thread.
#pragma once

#include <cstddef>

#include "core/recover/network.h"

namespace qray {

constexpr int kBorder = kDilations.back();  // blocks: the farthest tap

// `count` numbers of each block: rows of them one after the other, so that a row's lie together.
struct Planes {
  float* first = nullptr;    // of block (0, 0)
  std::ptrdiff_t pitch = 0;  // floats from number to number of a row
  int count = 0;

  float* at(int k, int y, int x) const {
    return first + (static_cast<std::ptrdiff_t>(y) * count + k) * pitch + x;
  }
};

struct InferRows {
  int width = 0, height = 0;  // blocks
  int hidden = 0;
  const float *weights1, *bias1, *weights2, *bias2, *weights3, *bias3, *scales;  // scales: not logs
  Planes features;            // kBlock x kFeatures
  Planes colour, noise;       // as the network's input
  Planes known;               // colour / albedo
  Planes layer1, layer2;      // `hidden`
  Planes kernels[kFilters];   // kTaps each; none for the first, which is used at once
  Planes filtered[kFilters];  // kColour
  float* out = nullptr;       // the picture: rows of pixels, 3 channels
};

// Stages, each over all rows before the next; borders above and below a stage's planes are copied
// in between.
struct InferLoops {
  void (*layer1_row)(const InferRows&, int y);
  void (*first_filter_row)(const InferRows&, int y);
  void (*later_filter_row)(const InferRows&, int y, int filter);
  void (*pixels_row)(const InferRows&, int y);
};

const InferLoops& common_loops();  // for what the project is compiled for
const InferLoops& avx512_loops();  // only where the processor has AVX-512 F, VL, BW, DQ

}  // namespace qray
