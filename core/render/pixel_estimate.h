// About how bright each pixel will be: the picture so far, blurred. Russian roulette weighs a
// path's worth against it. Updated between passes; read by any thread in between.
#pragma once

#include <vector>

#include "core/film/film.h"

namespace qray {

class PixelEstimate {
 public:
  void update(const Film& film);
  // Luminance; 0: not known.
  float at(int x, int y) const {
    return luminance_.empty() ? 0.0f
                              : luminance_[static_cast<size_t>(y) * static_cast<size_t>(width_) +
                                           static_cast<size_t>(x)];
  }

 private:
  int width_ = 0;
  std::vector<float> luminance_;
};

}  // namespace qray
