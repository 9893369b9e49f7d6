#include "core/recover/training_view.h"

#include <algorithm>

#include "core/base/check.h"

namespace qray {
namespace {

// The pixel of the picture that stands at (x, y) of the turned one.
struct Turn {
  const Image& image;
  Flip flip;
  void operator()(int& x, int& y) const {
    x = std::clamp(x, 0, image.width() - 1);
    y = std::clamp(y, 0, image.height() - 1);
    if (flip.mirror_x) x = image.width() - 1 - x;
    if (flip.mirror_y) y = image.height() - 1 - y;
    if (flip.exchange) std::swap(x, y);
  }
};

}  // namespace

Image turned(const Image& image, int y, int x, int height, int width, Flip flip) {
  QRAY_CHECK(!flip.exchange || image.width() == image.height());
  const Turn turn{image, flip};
  Image out(width, height, image.channels());
  for (int ty = 0; ty < height; ++ty)
    for (int tx = 0; tx < width; ++tx) {
      int px = x + tx, py = y + ty;
      turn(px, py);
      for (int c = 0; c < image.channels(); ++c) out.at(tx, ty, c) = image.at(px, py, c);
    }
  return out;
}

}  // namespace qray
