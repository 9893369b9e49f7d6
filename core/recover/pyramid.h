// The network that cleans samples: a small U-net whose answers are the weights of filters on six
// levels of the picture, from pixels (level 0) to squares of 32 x 32 (level 5). It never makes a
// colour itself.
//
//   input    of each block of 2 x 2 pixels: their colour / albedo in the picture's own exposure, as
//            a logarithm, their noise, what they show of lights, and their features
//   layers   1x1; then 3x3 at levels 1 to 5 and back at 4 to 1, each on the mean of four
//            cells, or on the coarser level beside its own (a sum); all of kPyramidChannels
//   coarser  a cell's colour is a mean of its four, by a softmax of a logit of each
//   finer    from level 5 down: a cell's result is a mean of the 9 colours around it and of the
//            results of the 4 nearest cells of the coarser level, by a softmax of 13 logits, less
//            the distances of the taps' features in learned scales
//
// So each result is a convex combination of colours around, which invents nothing. The shape is
// that of kernel-predicting denoisers (Vogels et al., "Denoising with Kernel Prediction and
// Asymmetric Loss Functions", 2018). Any thread.
#pragma once

#include <vector>

#include "core/recover/network.h"

namespace qray {

constexpr int kPyramidLevels = 6;
constexpr int kPyramidSide = 1 << (kPyramidLevels - 1);  // pixels of the coarsest cells
constexpr int kPyramidChannels = 32;
constexpr int kBlock = 4;       // pixels of a block of 2 x 2, row by row
constexpr float kSlope = 0.1f;  // of the leaky units
// Colour; noise of the surroundings, and the pixel's own; what it shows of lights; features.
constexpr int kPixelNoise = kColour, kPixelOwnNoise = kPixelNoise + 1,
              kPixelShown = kPixelOwnNoise + 1, kPixelFeatures = kPixelShown + 1,
              kPixelInputs = kPixelFeatures + kFeatures;
constexpr int kPyramidInputs = kBlock * kPixelInputs;

constexpr int kTaps = 9;  // row by row, the middle one fifth
constexpr int kCoarseTaps = 4;
constexpr int kPyramidTaps = kTaps + kCoarseTaps;
constexpr int kCellLogits = 16;  // of a cell's filter, with padding
// What follows the filter's logits in the head of a level: the logit by which a cell counts in the
// coarser one and, of level 1, those of its four pixels too.
constexpr int kCoarsenLogit = kPyramidTaps;
constexpr int kPixelCoarsenLogits = kCoarsenLogit + 1;

// A convolution; its weights lie [tap][input][output], then its biases.
struct PyramidLayer {
  int side, inputs, outputs;
  size_t weights, bias;  // where they begin in the values
};

enum PyramidPart {
  kFirstLayer,
  kDown1,
  kDown2,
  kDown3,
  kDown4,
  kDown5,
  kUp4,
  kUp3,
  kUp2,
  kUp1,
  kHead5,
  kHead4,
  kHead3,
  kHead2,
  kHead1,
  kHead0,  // kCellLogits for each pixel of the block
  kPyramidParts
};

PyramidLayer pyramid_layer(PyramidPart part);

// Logarithms, kDistances for the taps of the level itself and as many for the coarser ones, level
// by level.
size_t pyramid_scales();
size_t pyramid_size();  // of all values

// Its heads have no weights yet: a joint bilateral filter on six levels.
Network untrained_network(uint64_t seed);

}  // namespace qray
