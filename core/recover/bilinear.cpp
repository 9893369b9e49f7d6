#include "core/recover/bilinear.h"

#include <algorithm>

#include "core/base/check.h"

namespace qray {

Image bilinear_recovery(const Image& input) {
  QRAY_CHECK(input.width() % 2 == 0 && input.height() % 2 == 0);
  Image out(input.width(), input.height(), 3);
  for (int y = 0; y < input.height(); ++y)
    for (int x = 0; x < input.width(); ++x) {
      const int x0 = x / 2 * 2, y0 = y / 2 * 2;
      const int x1 = x % 2 ? std::min(x0 + 2, input.width() - 2) : x0;
      const int y1 = y % 2 ? std::min(y0 + 2, input.height() - 2) : y0;
      out.set_rgb(
          x, y,
          (input.rgb(x0, y0) + input.rgb(x1, y0) + input.rgb(x0, y1) + input.rgb(x1, y1)) * 0.25f);
    }
  return out;
}

}  // namespace qray
