// What a guess gets wrong by how bright it is: light that comes by few bright samples is missing
// where it is bright, or everywhere.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "core/image/image.h"
#include "core/recover/energy.h"

namespace qray {

// Eight classes of pixels, from the darkest of a guess to the brightest. Each moves to the energy
// of its samples as far as these are sure of it, and between classes the factor changes gradually.
// Rows may be added and multiplied by several threads.
class BrightnessClasses {
 public:
  static constexpr size_t kClasses = 8;
  struct Sum {
    Energy energy;
    double luminance = 0, count = 0;
  };
  using Sums = std::array<Sum, kClasses>;

  // Of a guess of which every `step`th pixel of every `step`th row has samples.
  BrightnessClasses(const Image& guess, int step);

  // Rows of `width` pixels, [pixel][3].
  void add_row(const float* samples, const float* guess, int width, Sums& sums) const;
  // What each class is to be multiplied by, by the sums of some rows each; false: all are as they
  // should be.
  bool set_factors(std::span<const Sums> parts);
  void multiply_row(float* picture, int width) const;

 private:
  std::array<float, kClasses - 1> bounds_{};
  std::array<float, kClasses> middles_{};
  std::array<Rgb, kClasses> factors_{};
};

}  // namespace qray
