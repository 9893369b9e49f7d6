// From what is known of a frame's pixels to its picture. One thread calls; the pool's work.
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "core/live/history.h"
#include "core/recover/guess.h"

namespace qray {

// What the samples in each block of 2 x 2 pixels say together.
struct BlockHistory {
  Rgb light;            // over albedo; of the first pixel's surface where that was sampled
  float samples = 0;    // 0: nothing was near
  float variance = 0;   // of a sample's luminance, with those around
  float luminance = 0;  // of the light, with those around
  // Standard error of the light's luminance by these samples alone; fewer than two tell none.
  float own_error = std::numeric_limits<float>::infinity();
};

class BlockGrid {
 public:
  BlockGrid(const ViewBuffer& view, const History& history, TaskPool& pool);
  int width() const { return width_; }
  const BlockHistory& of_pixel(int x, int y) const { return at(x / 2, y / 2); }
  const BlockHistory& at(int bx, int by) const {
    return blocks_[static_cast<size_t>(by) * static_cast<size_t>(width_) + static_cast<size_t>(bx)];
  }
  // Mean over blocks of the standard error over the light: of the samples, before recovery.
  double noise() const;

 private:
  void measure_noise(TaskPool& pool);
  int width_, height_;
  std::vector<BlockHistory> blocks_;
};

// Of samples alone: pixels that have none show their block's.
Image sampled_picture(const ViewBuffer& view, const History& history, const BlockGrid& blocks,
                      TaskPool& pool);

// The network's guess, a mean over the last frames' where `guesses` has them, and the samples by as
// much as they are surer. The mean is kept in `guesses`. `knows_pixels`: the guess is made of all
// pixels, which takes longer, instead of the blocks'.
Image recovered_picture(const ViewBuffer& view, const History& history, const BlockGrid& blocks,
                        bool knows_pixels, Guess& recovery, History& guesses, TaskPool& pool);

// Between the picture's pixels.
Image enlarged(const Image& picture, int width, int height, TaskPool& pool);

}  // namespace qray
