// A picture, or a part of one, as the network sees it: by blocks of 2 x 2 pixels. Plain data.
#pragma once

#include <vector>

#include "core/recover/convolve.h"
#include "core/recover/network.h"

namespace qray {

struct BlockTile {
  int height = 0, width = 0;  // blocks
  Grid input;                 // kInputs channels, with a block more on each side
  std::vector<float> known;   // colour / albedo of each block's known pixel: 3 planes
  std::vector<float> albedo;  // + kAlbedoFloor: [block][pixel][3]

  size_t blocks() const { return static_cast<size_t>(height) * static_cast<size_t>(width); }
  const float* features(int y, int x, int pixel) const {
    return input.at(y + 1, x + 1) + kInputFeatures + pixel * kFeatures;
  }
};

}  // namespace qray
