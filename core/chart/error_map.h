// A picture of where another one is wrong: the relative squared error of each pixel, mean over
// channels of (x-r)^2/(r^2+0.01), on one logarithmic scale for all charts. Any thread.
#pragma once

#include "core/image/image.h"

namespace qray {

// The ends of the scale; what lies outside has the colour of the end.
constexpr float kErrorMapLow = 1e-4f, kErrorMapHigh = 1;

// Pictures of one size, 3 channels.
Image error_map(const Image& picture, const Image& reference);

}  // namespace qray
