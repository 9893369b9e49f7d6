// Means of squares of a picture. Any thread; the pool's work.
#pragma once

#include "core/base/task_pool.h"
#include "core/image/image.h"

namespace qray {

// Of three channels: the mean of the pixels within `radius` of each pixel, beside and above, of
// which every `step`th of every `step`th row is known. No mean is below 0.
Image box_mean(const Image& image, int radius, int step, TaskPool& pool);

}  // namespace qray
