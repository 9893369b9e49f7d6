// Which pixels a pass samples, and how often. Sampled pixels lie `step` apart and are counted in
// that grid. Where counts go by noise, a pixel gets more where samples scatter more, against what
// they are like, once that is known and where it lowers the picture's variance enough. What a
// pass counts for must not depend on how many samples a pixel got: see Film::add(). A region may
// get its samples before the other pixels: whatever their values, so that this changes no mean.
// Between passes one thread; readers from any.
#pragma once

#include <cstdint>
#include <vector>

#include "core/film/film.h"
#include "core/render/noise_estimate.h"
#include "core/settings/render_settings.h"

namespace qray {

class PixelPlan {
 public:
  // `in_rounds`: a pass takes every other pixel of every other row, then the others in three more
  // rounds, so that its parts cover the picture evenly. Else it is one round. Of pixels kAll alone.
  explicit PixelPlan(const RenderSettings& settings, bool in_rounds = false);

  int step() const { return step_; }    // pixels
  int width() const { return width_; }  // of the grid
  int height() const { return height_; }
  uint64_t pixels() const { return static_cast<uint64_t>(width_) * static_cast<uint64_t>(height_); }
  bool by_noise() const { return by_noise_; }
  int rounds() const { return in_rounds_ ? 4 : 1; }
  // Calls body(x, y) for the picture's pixels that a round takes of a tile, row by row, while it
  // returns true. False: it did not.
  template <class Body>
  bool for_each_in_round(int round, const TileRect& tile, Body body) const {
    const int stride = in_rounds_ ? 2 : step_;
    for (int y = tile.y + kRoundY[round]; y < tile.y + tile.height; y += stride)
      for (int x = tile.x + kRoundX[round]; x < tile.x + tile.width; x += stride)
        if (!body(x, y)) return false;
    return true;
  }

  // As many samples as `samples` for each pixel of the grid would be; with a region a few less,
  // which later passes make up for. `noise`: null, not used.
  void start_pass(int samples, const NoiseEstimate* noise);
  // The pixel's samples in this pass, and how many it had before.
  uint32_t count(int x, int y) const {
    return !counts_.empty() ? counts_[index(x, y)] : region_.has(x, y) ? in_region_ : samples_;
  }
  uint32_t first(int x, int y) const {
    return !counts_.empty() ? done_each_[index(x, y)] : region_.has(x, y) ? done_in_region_ : done_;
  }
  void end_pass();
  size_t index(int x, int y) const {  // row by row
    return static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x);
  }

  template <class Self, class Archive>
  static void exchange(Self& self, Archive& archive) {
    archive(self.samples_, self.done_, self.in_region_, self.done_in_region_, self.spare_,
            self.counts_, self.done_each_);
  }
  // Whether what was read is of this grid.
  bool fits() const {
    return counts_.size() == done_each_.size() && (counts_.empty() || counts_.size() == pixels());
  }

 private:
  // Of the grid, from the first column and row to before the last.
  struct Region {
    int x = 0, y = 0, end_x = 0, end_y = 0;
    bool has(int column, int row) const {
      return column >= x && column < end_x && row >= y && row < end_y;
    }
    uint64_t pixels() const {
      return static_cast<uint64_t>(end_x - x) * static_cast<uint64_t>(end_y - y);
    }
  };
  static Region region_of(const RenderSettings& settings, int step);
  void share_out(int samples, const NoiseEstimate& noise);
  void prefer_region();

  static constexpr int kRoundX[] = {0, 1, 1, 0}, kRoundY[] = {0, 1, 0, 1};

  bool by_noise_, in_rounds_;
  uint64_t seed_;
  int step_, width_, height_;
  Region region_;                    // without pixels: none comes first
  uint32_t most_;                    // samples a pixel, of the whole render; 0: not known
  uint32_t samples_ = 0, done_ = 0;  // a pixel outside of the region, while all there are alike
  uint32_t in_region_ = 0, done_in_region_ = 0;
  uint64_t spare_ = 0;  // samples of earlier passes that could not be given to all alike
  std::vector<uint32_t> counts_, done_each_;  // empty while all are alike
};

}  // namespace qray
