// What light is like around each pixel of sampled ones, in about 32 x 32 of them. Immutable once
// made; any thread.
#pragma once

#include <vector>

#include "core/base/task_pool.h"
#include "core/image/image.h"

namespace qray {

class Surroundings {
 public:
  // `own_error`: standard error of each pixel's luminance, one channel. Where it is infinite,
  // that is not known, the difference from a neighbour takes its place. The pool's work.
  Surroundings(const Image& samples, const Image& own_error, TaskPool& pool);

  // How bright a pixel is that one hit lights, if all light comes from hits that are alike:
  // variance over mean. Light that few samples meet has bright ones. Where all is black, the
  // picture's, as far as all of so many samples may have missed these.
  Rgb light_of_a_hit(int x, int y) const;

 private:
  int width_ = 0, height_ = 0;  // cells
  std::vector<Rgb> hits_;
};

}  // namespace qray
