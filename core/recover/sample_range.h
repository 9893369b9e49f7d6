// How dark and how bright the samples around a pixel allow it to be. Any thread; the pool's work.
#pragma once

#include <cstdint>

#include "core/base/task_pool.h"
#include "core/image/image.h"
#include "core/recover/surroundings.h"

namespace qray {

// Each channel of a pixel lies between the least and the largest of the samples in the 7 x 7 pixels
// around it. It may be brighter than the largest as far as the light that it has more may come of
// hits (surroundings.h) that all of these samples may have missed.
class SampleRange {
 public:
  // `samples`: of every `step`th pixel of every `step`th row, 1 or 2. `own_error`: of
  // them, as surroundings.h has it.
  SampleRange(const Image& samples, const Image& own_error, int step, TaskPool& pool);

  // Moves row y of a whole picture into the range; how many of its pixels were out of it.
  uint64_t hold_row(Image& picture, int y) const;

 private:
  Rgb may_be_missed(int x, int y) const;

  int step_, radius_;
  Image least_, largest_;  // of the samples around each
  Surroundings around_;
};

}  // namespace qray
