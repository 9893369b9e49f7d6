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

BlockTile tile_of(const Image& features, const Image& input, const Image& noise, int y, int x,
                  int height, int width, Flip flip) {
  QRAY_CHECK(features.channels() == kFeatures && features.width() % 2 == 0 &&
             features.height() % 2 == 0);
  QRAY_CHECK(!flip.exchange || features.width() == features.height());
  BlockTile tile;
  tile.height = height, tile.width = width;
  tile.input.resize(height + 2, width + 2, kInputs);
  tile.known.resize(3 * tile.blocks());
  tile.albedo.resize(3 * kBlock * tile.blocks());
  const Turn turn{features, flip};
  for (int ty = -1; ty <= height; ++ty)
    for (int tx = -1; tx <= width; ++tx) {
      const int by = std::clamp(y + ty, 0, features.height() / 2 - 1);
      const int bx = std::clamp(x + tx, 0, features.width() / 2 - 1);
      const bool inside = ty >= 0 && ty < height && tx >= 0 && tx < width;
      const size_t block = static_cast<size_t>(ty) * static_cast<size_t>(width) +
                           static_cast<size_t>(tx);  // where inside
      float* in = tile.input.at(ty + 1, tx + 1);
      for (int s = 0; s < kBlock; ++s) {
        int px = 2 * bx + s % 2, py = 2 * by + s / 2;
        turn(px, py);
        float* f = in + kInputFeatures + s * kFeatures;
        for (int k = 0; k < kFeatures; ++k) f[k] = features.at(px, py, k);
        for (int c = 0; c < 3; ++c) {
          const float albedo = f[c] + kAlbedoFloor;
          if (inside)
            tile.albedo[(block * kBlock + static_cast<size_t>(s)) * 3 + static_cast<size_t>(c)] =
                albedo;
          if (s != 0) continue;
          const float colour = input.at(px, py, c) / albedo;
          in[c] = colour / (1 + colour);
          if (inside) tile.known[static_cast<size_t>(c) * tile.blocks() + block] = colour;
        }
        if (s == 0) in[kInputNoise] = noise.at(px, py, 0);
      }
    }
  return tile;
}

std::vector<float> target_of(const TrainingView& view, int y, int x, int height, int width,
                             Flip flip) {
  const Turn turn{view.target, flip};
  std::vector<float> target;
  target.reserve(static_cast<size_t>(height * width * kBlock * 3));
  for (int by = y; by < y + height; ++by)
    for (int bx = x; bx < x + width; ++bx)
      for (int s = 0; s < kBlock; ++s) {
        int px = 2 * bx + s % 2, py = 2 * by + s / 2;
        turn(px, py);
        for (int c = 0; c < 3; ++c) target.push_back(view.target.at(px, py, c));
      }
  return target;
}

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
