// How noisy one sample of each pixel is, about: from how far each pass' picture lies from that of
// all passes before it, blurred. Russian roulette weighs against it what a path may still bring.
// Updated between passes; read by any thread in between.
#pragma once

#include <vector>

#include "core/film/film.h"

namespace qray {

class PixelEstimate {
 public:
  // `samples`: a pixel, in the film.
  void update(const Film& film, uint64_t samples);
  // Standard deviation of a sample's luminance; 0: not known.
  float deviation(int x, int y) const {
    return deviation_.empty() ? 0.0f
                              : deviation_[static_cast<size_t>(y) * static_cast<size_t>(width_) +
                                           static_cast<size_t>(x)];
  }

 private:
  int width_ = 0;
  uint64_t samples_ = 0;
  std::vector<float> mean_;      // luminance, of all samples so far
  std::vector<float> distance_;  // a pass' from the mean before, per sample; faded over passes
  std::vector<float> deviation_;
};

}  // namespace qray
