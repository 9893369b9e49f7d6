// The simplest recovery: pixels between the known ones are interpolated. Any thread.
#pragma once

#include "core/image/image.h"

namespace qray {

// The first pixel of each 2 x 2 block of `input` (linear colour, even sides) is known; beyond the
// last ones it continues evenly.
Image bilinear_recovery(const Image& input);

}  // namespace qray
