// What the pixels of a tile got in one round of a pass: sums of their samples of even and of odd
// number, whose distance tells the noise. One thread's, used for tile after tile.
#pragma once

#include <span>
#include <vector>

#include "core/film/film.h"
#include "core/render/path_state.h"

namespace qray {

class TileSamples {
 public:
  void start(const TileRect& rect) {
    rect_ = rect;
    const size_t pixels = static_cast<size_t>(rect.width) * static_cast<size_t>(rect.height);
    halves_.assign(2 * pixels, Rgb{});
    counts_.assign(pixels, 0);
    saved_.assign(pixels, 0);
  }
  const TileRect& rect() const { return rect_; }

  // Coordinates are the picture's. Where a sample of that number belongs; stays until start().
  PixelTarget target(int x, int y, uint32_t number) {
    return {halves_[2 * index(x, y) + (number & 1)], &saved_[index(x, y)]};
  }
  Rgb even(int x, int y) const { return halves_[2 * index(x, y)]; }
  Rgb odd(int x, int y) const { return halves_[2 * index(x, y) + 1]; }
  Rgb sum(int x, int y) const { return even(x, y) + odd(x, y); }
  void set_count(int x, int y, uint32_t count) { counts_[index(x, y)] = count; }
  uint32_t count(int x, int y) const { return counts_[index(x, y)]; }
  double saved(int x, int y) const { return saved_[index(x, y)]; }  // PixelTarget, of all samples

  // Of each pixel, in rows; zero where a pixel had none. Once all samples are there.
  std::span<const Rgb> sums() {
    sums_.resize(counts_.size());
    for (size_t i = 0; i < sums_.size(); ++i) sums_[i] = halves_[2 * i] + halves_[2 * i + 1];
    return sums_;
  }
  std::span<const uint32_t> counts() const { return counts_; }

 private:
  size_t index(int x, int y) const {
    return static_cast<size_t>(y - rect_.y) * static_cast<size_t>(rect_.width) +
           static_cast<size_t>(x - rect_.x);
  }

  TileRect rect_;
  std::vector<Rgb> halves_, sums_;
  std::vector<uint32_t> counts_;
  std::vector<double> saved_;
};

}  // namespace qray
