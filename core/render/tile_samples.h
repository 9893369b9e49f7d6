// What the pixels of a tile got in one round of a pass: sums of their samples by quarters, whose
// distances tell the noise. One thread's, used for tile after tile.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "core/base/snapshot.h"
#include "core/film/film.h"
#include "core/render/path_state.h"

namespace qray {

// A pass' samples of one pixel, or what they tell, in two ways to halve them (noise_estimate.h).
template <class T>
struct SampleHalves {
  T even, odd, earlier, later;
};

class TileSamples {
 public:
  // `layers`: that each pixel has.
  void start(const TileRect& rect, int layers = 0) {
    rect_ = rect;
    layer_count_ = static_cast<size_t>(layers);
    const size_t pixels = static_cast<size_t>(rect.width) * static_cast<size_t>(rect.height);
    quarters_.assign(pixels, {});
    counts_.assign(pixels, 0);
    saved_.assign(pixels, 0);
    seen_.assign(pixels, {});
    layers_.assign(pixels * layer_count_, {});
  }
  const TileRect& rect() const { return rect_; }

  // Coordinates are the picture's. Where a sample of that number belongs, of a pixel that gets
  // `count` from number `first` on; stays until start().
  PixelTarget target(int x, int y, uint32_t first, uint32_t count, uint32_t number) {
    const bool later = number - first >= even_count(first, count);
    return {&quarters_[index(x, y)][2 * later + (number & 1)], &saved_[index(x, y)],
            &seen_[index(x, y)], layer_count_ > 0 ? &layers_[index(x, y) * layer_count_] : nullptr};
  }
  // How many of them have even numbers; as many are earlier ones.
  static uint32_t even_count(uint32_t first, uint32_t count) {
    return (count + 1 - (first & 1)) / 2;
  }
  SampleHalves<Rgb> halves(int x, int y) const {
    const Quarters& q = quarters_[index(x, y)];
    return {q[0] + q[2], q[1] + q[3], q[0] + q[1], q[2] + q[3]};
  }
  Rgb sum(int x, int y) const { return sum(quarters_[index(x, y)]); }
  void set_count(int x, int y, uint32_t count) { counts_[index(x, y)] = count; }
  uint32_t count(int x, int y) const { return counts_[index(x, y)]; }
  double saved(int x, int y) const { return saved_[index(x, y)]; }  // PixelTarget, of all samples

  // Of each pixel, in rows; zero where a pixel had none. Once all samples are there.
  std::span<const Rgb> sums() {
    sums_.resize(counts_.size());
    for (size_t i = 0; i < sums_.size(); ++i) sums_[i] = sum(quarters_[i]);
    return sums_;
  }
  std::span<const uint32_t> counts() const { return counts_; }
  std::span<const Rgb> seen() const { return seen_; }      // of each pixel's sum, PixelTarget::seen
  std::span<const Rgb> layers() const { return layers_; }  // of each pixel, side by side

  // All of it, for another process. What is zero everywhere is left out: in early passes that is
  // most.
  void save(SnapshotWriter& out) const {
    out(rect_.width, rect_.height);
    std::vector<Rgb> quarter(quarters_.size());
    for (size_t k = 0; k < kQuarters; ++k) {
      for (size_t i = 0; i < quarter.size(); ++i) quarter[i] = quarters_[i][k];
      save_unless_zero(quarter, out);
    }
    save_unless_zero(counts_, out);
    save_unless_zero(saved_, out);
    save_unless_zero(seen_, out);
    save_unless_zero(layers_, out);
  }
  // Of a tile that lies there, of so many layers. What does not fit turns `in` not ok.
  void load(const TileRect& rect, int layers, SnapshotReader& in) {
    int width = 0, height = 0;
    in(width, height);
    if (width != rect.width || height != rect.height) return in.fail();
    start(rect, layers);
    std::vector<Rgb> quarter(quarters_.size());
    for (size_t k = 0; k < kQuarters; ++k) {
      load_unless_zero(quarter, in);
      for (size_t i = 0; i < quarter.size(); ++i) quarters_[i][k] = quarter[i];
    }
    load_unless_zero(counts_, in);
    load_unless_zero(saved_, in);
    load_unless_zero(seen_, in);
    load_unless_zero(layers_, in);
  }

 private:
  static constexpr size_t kQuarters = 4;
  using Quarters = std::array<Rgb, kQuarters>;  // earlier even, earlier odd, later even, later odd
  static Rgb sum(const Quarters& q) { return (q[0] + q[1]) + (q[2] + q[3]); }
  template <class T>
  static void save_unless_zero(const std::vector<T>& values, SnapshotWriter& out) {
    const bool any = std::any_of(values.begin(), values.end(), [](const T& v) { return v != T{}; });
    out(any);
    // A copy: a snapshot has a vector's capacity, which tells of the tiles before.
    if (any) out(std::vector<T>(values.begin(), values.end()));
  }
  template <class T>
  static void load_unless_zero(std::vector<T>& values, SnapshotReader& in) {
    const size_t size = values.size();
    bool any = false;
    in(any);
    if (any) in(values);
    if (!any) values.assign(size, T{});
    if (values.size() != size) in.fail(), values.assign(size, T{});
  }
  size_t index(int x, int y) const {
    return static_cast<size_t>(y - rect_.y) * static_cast<size_t>(rect_.width) +
           static_cast<size_t>(x - rect_.x);
  }

  TileRect rect_;
  std::vector<Quarters> quarters_;
  size_t layer_count_ = 0;
  std::vector<Rgb> sums_, seen_, layers_;
  std::vector<uint32_t> counts_;
  std::vector<double> saved_;
};

}  // namespace qray
