// What a guess gets wrong by how bright it is: light that comes by few bright samples is missing
// where it is bright, or everywhere. Any thread; the pool's work.
#pragma once

#include "core/base/task_pool.h"
#include "core/image/image.h"

namespace qray {

// Of eight classes of pixels, from the darkest of `guess` to the brightest, each moves to the
// energy of its samples as far as these are sure of it. Between classes the factor changes
// gradually. Every `step`th pixel of every `step`th row of `samples` is known.
void balance_by_brightness(Image& guess, const Image& samples, int step, TaskPool& pool);

}  // namespace qray
