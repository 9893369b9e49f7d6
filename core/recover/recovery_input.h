// What a whole picture is made of. Plain data.
#pragma once

#include "core/image/image.h"

namespace qray {

// A picture's guides beside its light; images of one size.
struct RecoveryInput {
  Image features;     // kFeatures channels, every pixel
  Image colour;       // linear, where it is known; none below 0
  Image noise;        // one channel, there: r / (1 + r), r the standard error over the mean
  Image own_error{};  // one channel: of the luminance, by two halves of a pixel's samples
  // Of lights and the environment themselves, seen directly: not in `colour`, and added to what is
  // made of that. Empty: nothing.
  Image shown{};
};

}  // namespace qray
