// Differences between a picture and its reference. Pictures must have equal sizes and 3 channels,
// all finite. Any thread.
#pragma once

#include "core/base/result.h"
#include "core/image/flip.h"
#include "core/image/image.h"

namespace qray {

struct ImageDifference {
  double relmse = 0;          // mean over pixels and channels of (x-r)^2 / (r^2 + 0.01)
  double relmse_trimmed = 0;  // the same without the 0.1 % of pixels with the largest error
  double flip = 0;            // mean LDR-FLIP (Andersson et al. 2020), 67 pixels per degree
  double mean_ratio = 0;      // mean luminance of the picture over the reference's; 1 if both are 0
  double max_abs = 0;         // largest |x - r| of any channel
};

// The relmse alone, unchecked.
double relmse(const Image& picture, const Image& reference);

Result<ImageDifference> image_difference(const Image& picture, const Image& reference);

}  // namespace qray
