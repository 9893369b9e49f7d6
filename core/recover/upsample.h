// The picture from one pixel of each 2 x 2 that is known and clean: joint bilateral upsampling
// (Kopf et al. 2007). Any thread; the pool's work.
#pragma once

#include "core/base/task_pool.h"
#include "core/image/image.h"

namespace qray {

// `colour`: of the first pixel of each block, half as wide and high as `features` (network.h). What
// is over albedo there is weighted, for every pixel, from the one, two or four blocks that are
// nearest, by how alike their features are.
Image upsampled(const Image& colour, const Image& features, TaskPool& pool);

}  // namespace qray
