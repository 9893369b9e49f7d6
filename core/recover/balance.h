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

// `guess` made to agree with the samples, of which every `step`th pixel of every `step`th row is
// known:
//
//   range   each channel lies between the least and the largest of the samples in 7 x 7 pixels;
//           where all of these are black light is rare, and it may be as bright as the mean of
//           31 x 31 and three of its errors or, where these are black too, as the picture's mean;
//           less where so many of the 31 x 31 met light that the 7 x 7 are not black by chance
//   energy  that of pixels about as bright (brightness.h), the picture's, and that of each square
//           of it, from halves down to 64 pixels, is the samples' as far as these are sure of it
//           (energy.h)
//
// The factors are smooth over the picture, so that squares do not show.
Recovered balanced(Image guess, const Image& samples, int step, TaskPool& pool);

}  // namespace qray
