// What FastRecovery's loops read and write. Plain data, for one thread: rows of blocks go through
// the stages one behind the other, and only those that are still needed are kept, so that all stays
// in the processor's cache.
#pragma once

#include <bit>
#include <cstddef>

#include "core/recover/network.h"

namespace qray {

constexpr int kBorder = kDilations.back();  // blocks: the farthest tap

// By how many rows each filter, and then the four pixels, are behind the packing: a stage's taps
// reach rows below that the stage before has made.
constexpr std::array<int, kFilters + 1> kLags = [] {
  std::array<int, kFilters + 1> lags{kBorder};
  for (size_t f = 1; f < kFilters; ++f) lags[f] = lags[f - 1] + kDilations[f];
  lags[kFilters] = lags[kFilters - 1] + 1;
  return lags;
}();
constexpr int kPixelsLag = kLags[kFilters];

// `count` numbers of each block: rows of them one after the other, so that a row's lie together.
// Of the picture's rows the last `rows` are kept, a power of two.
struct Planes {
  float* first = nullptr;    // of block (0, 0)
  std::ptrdiff_t pitch = 0;  // floats from number to number of a row
  int count = 0, rows = 1;

  float* at(int k, int y, int x) const {
    return first + (static_cast<std::ptrdiff_t>(y & (rows - 1)) * count + k) * pitch + x;
  }
};

struct InferRows {
  int width = 0, height = 0;  // blocks
  int hidden = 0;
  const float *weights1, *bias1, *weights2, *bias2, *weights3, *bias3, *scales;  // scales: not logs
  // The picture's pixels, as FastRecovery::run() takes them.
  const float *pixel_features = nullptr, *pixel_colour = nullptr, *pixel_noise = nullptr;
  float* out = nullptr;       // 3 channels
  Planes features;            // kBlock x kFeatures
  Planes colour, noise;       // as the network's input
  Planes known;               // colour / albedo
  Planes layer1, layer2;      // `hidden`
  Planes kernels[kFilters];   // kTaps each; none for the first, which is used at once
  Planes filtered[kFilters];  // kColour
};

// Stages of a row of blocks. Taps beyond the picture take its edge.
struct InferLoops {
  void (*pack_row)(const InferRows&, int y);  // and the first layer
  void (*first_filter_row)(const InferRows&, int y);
  void (*later_filter_row)(const InferRows&, int y, int filter);
  void (*pixels_row)(const InferRows&, int y);
};

const InferLoops& common_loops();  // for what the project is compiled for
const InferLoops& avx512_loops();  // only where the processor has AVX-512 F, VL, BW, DQ

}  // namespace qray
