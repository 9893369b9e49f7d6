// A picture made smaller, for a list of many. Pure.
#pragma once

#include <algorithm>

#include "core/image/image.h"

namespace qray {

// Its longer side at most `side` pixels: each pixel is the mean of those that lie in it.
inline Image shrunk(const Image& image, int side) {
  const int longer = std::max(image.width(), image.height());
  if (longer <= side) return image;
  const auto scaled = [&](int pixels) {
    return std::max(1, static_cast<int>(static_cast<int64_t>(pixels) * side / longer));
  };
  Image small(scaled(image.width()), scaled(image.height()), image.channels());
  for (int y = 0; y < small.height(); ++y)
    for (int x = 0; x < small.width(); ++x) {
      const auto edge = [](int at, int of, int whole) {
        return static_cast<int>(static_cast<int64_t>(at) * whole / of);
      };
      const int x0 = edge(x, small.width(), image.width());
      const int x1 = edge(x + 1, small.width(), image.width());
      const int y0 = edge(y, small.height(), image.height());
      const int y1 = edge(y + 1, small.height(), image.height());
      for (int c = 0; c < image.channels(); ++c) {
        float sum = 0;
        for (int v = y0; v < y1; ++v)
          for (int u = x0; u < x1; ++u) sum += image.at(u, v, c);
        small.at(x, y, c) = sum / static_cast<float>((x1 - x0) * (y1 - y0));
      }
    }
  return small;
}

}  // namespace qray
