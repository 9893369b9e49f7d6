// What a recovered picture owes its samples: no more light than they saw, and no less. Any thread;
// the pool's work.
#pragma once

#include <cstdint>

#include "core/base/task_pool.h"
#include "core/image/image.h"

namespace qray {

// A picture made of samples, and how many of its pixels were guessed out of the range of the
// samples around them, and held to it.
struct Recovered {
  Image picture;
  uint64_t held = 0;
};

// `guess` made to agree with `samples`, which are as large, or half as wide and high: of the first
// pixel of each block of 2 x 2. `own_error`: standard error of their luminance, one channel;
// infinite: not known.
//
//   range   each pixel is as bright as the samples around it and chance allow (sample_range.h)
//   energy  that of pixels about as bright (brightness.h), the picture's, and that of each square
//           of it, from halves down to 64 pixels, is the samples' as far as these are sure of it
//           (energy.h)
//
// The factors are smooth over the picture, so that squares do not show.
Recovered balanced(Image guess, const Image& samples, const Image& own_error, TaskPool& pool);

}  // namespace qray
