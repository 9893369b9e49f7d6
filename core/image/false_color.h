// Colours for numbers. Any thread.
#pragma once

#include "core/math/vec.h"

namespace qray {

// Viridis (van der Walt and Smith 2015), safe for the colour-blind and monotone in lightness, at
// t in [0, 1] (others: the nearer end; NaN: 0); linear Rec.709.
Rgb viridis(float t);

// Blue at -1 over white to red at 1 (others: the nearer end; NaN: white), safe for the
// colour-blind: the ends of the diverging map of Moreland 2009; linear Rec.709.
Rgb diverging(float t);

// A logarithmic scale: `low` is 0, `high` is 1.
inline float log_scale(float v, float low, float high) {
  return std::log2(v / low) / std::log2(high / low);
}

}  // namespace qray
