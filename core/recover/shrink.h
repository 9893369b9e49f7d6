// Samples where they are sure, a guess where they are not. Any thread; the pool's work.
#pragma once

#include "core/base/task_pool.h"
#include "core/image/image.h"

namespace qray {

// Each pixel of `samples` moved towards `guess` as far as its noise asks for: empirical Bayes
// (Efron and Morris, "Stein's Estimation Rule and Its Competitors", 1973). The guess is the prior's
// mean; the prior's variance is what the distances of samples from it, in 7 x 7 pixels, leave over
// their noise, less where few pixels tell much. The more samples, the less of the guess: the
// picture converges to what samples alone do. Pixels that met less light than the guess has are no
// surer than chance allows where light is rare (surroundings.h). `own_error`: standard error of
// each pixel's luminance, one channel; infinite: not known.
Image shrink_towards(const Image& guess, const Image& samples, const Image& own_error,
                     TaskPool& pool);

}  // namespace qray
