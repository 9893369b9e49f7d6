#include <algorithm>
#include <cmath>

#include "core/recover/pyramid_pass.h"

namespace qray {

float exposure_of(const Image& colour) {
  constexpr int kSide = 16;
  constexpr float kBlack = 1e-8f;
  double sum = 0;
  int count = 0;
  for (int top = 0; top < colour.height(); top += kSide)
    for (int left = 0; left < colour.width(); left += kSide) {
      double light = 0;
      int pixels = 0;
      for (int y = top; y < std::min(top + kSide, colour.height()); ++y)
        for (int x = left; x < std::min(left + kSide, colour.width()); ++x, ++pixels)
          for (int c = 0; c < kColour; ++c) light += static_cast<double>(colour.at(x, y, c));
      light /= kColour * pixels;
      if (light <= static_cast<double>(kBlack)) continue;
      sum += std::log(light);
      ++count;
    }
  return count > 0 ? static_cast<float>(0.5 * std::exp(-sum / count)) : 1.0f;
}

}  // namespace qray
