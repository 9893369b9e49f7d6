// The picture as it forms: sums of samples per pixel, in 64 x 64 tiles that finish independently.
// Pixels may have samples more or less, or none.
// Each change of a tile gives it a new version, so a reader can ask for what changed since.
// Threads: add and the readers may be called from any thread; one tile is added by one thread at
// a time, in pass order, so the sums' bits do not depend on threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "core/base/snapshot.h"
#include "core/image/image.h"

namespace qray {

struct TileRect {
  int x = 0, y = 0, width = 0, height = 0;  // pixels
};

// What a film keeps beside the light of its pixels: parts of it, each in a layer of its own.
struct FilmLayers {
  int bounces = 0;  // by how often it was scattered: one for each number from 1 on, the last for
                    // all that are greater, too; 0: not told apart
  int groups = 0;   // by what it came from: one a group, after those; the pixels are their sum
  bool operator==(const FilmLayers&) const = default;

  int bounce(int number) const { return std::min(number, bounces) - 1; }  // number > 0
  int group(int number) const { return bounces + number; }
  int count() const { return group(groups); }
};

// Channels of Film::noise().
enum FilmNoise {
  kRelativeError,  // standard error over the mean, both of the pixel's surroundings
  kOwnError,       // standard error from two halves of its samples, infinite where it has not both
  kDeviation,      // of a sample, standard, of the pixel's surroundings
  kSamples,        // that it had
  kFilmNoiseChannels,
};

class Film {
 public:
  static constexpr int kTilePx = 64;

  Film(int width, int height, FilmLayers layers = {});

  int width() const { return width_; }
  int height() const { return height_; }
  const FilmLayers& layers() const { return layers_; }
  int tile_count() const { return static_cast<int>(tiles_.size()); }
  TileRect tile(int index) const;  // row by row from the top left

  // Adds what a pass of `samples` samples a pixel made of the tile: the sum of each pixel's, in
  // rows. `counts`: how many each had; empty: all as many. `seen`: what of the sums lights and the
  // environment showed of themselves; empty: nothing. `layers`: each pixel's, side by side. `each`:
  // every pixel that has samples weighs as if it had so many, 0: as many as it has. Where earlier
  // samples decide how many more there are, no weight may depend on that, or means are wrong: what
  // begins dark would be left so.
  void add(int index, std::span<const Rgb> sums, uint32_t samples,
           std::span<const uint32_t> counts = {}, std::span<const Rgb> seen = {},
           std::span<const Rgb> layers = {}, uint32_t each = 0);

  // What is there so far counts `keep` times as much, against what is added from here on.
  void fade(float keep);

  struct TileView {
    int index = 0;
    uint64_t version = 0;
    uint32_t samples = 0;   // a pixel, by the passes
    std::vector<Rgb> mean;  // black where a pixel has none
  };
  // `layer`: of this one, in place of the whole.
  TileView tile_view(int index, std::optional<int> layer = {}) const;
  struct Changes {
    std::vector<TileView> tiles;  // oldest change first
    uint64_t cursor = 0;          // give it back as `since`
    int left_out = 0;             // changed too, over the limit
  };
  // The newest version of any tile; 0: nothing was added yet.
  uint64_t version() const { return version_.load(std::memory_order_acquire); }
  // Tiles changed after `since`, at most `limit`. Following the cursor misses no change.
  Changes tiles_since(uint64_t since, int limit, std::optional<int> layer = {}) const;
  // Means; black where there is no sample yet. With groups the sum of their layers' means, in
  // their order.
  Image develop() const;
  Image seen() const;            // the part of them that was seen directly
  Image layer(int index) const;  // the part that this layer has
  Image indirect() const;        // the part that was scattered more than once; pre: bounces > 1

  // Of each pixel's luminance, as last estimated, in the channels of FilmNoise; zero but for the
  // first where a pixel has no samples.
  void set_noise(Image noise);
  std::shared_ptr<const Image> noise() const;  // null: not estimated

  // Sums and samples, not the noise. What is read must be of this size, else `in` fails; all of it
  // counts as changed since any cursor that was ever given.
  void save_state(SnapshotWriter& out) const;
  void load_state(SnapshotReader& in);

 private:
  struct Tile {
    mutable std::mutex mutex;
    uint64_t version = 0;
    uint32_t samples = 0;
    std::vector<Rgb> sums;       // empty until the first add
    std::vector<float> weights;  // parallel: of the samples in them
    std::vector<Rgb> seen;       // parallel: sums too
    std::vector<Rgb> layers;     // the same, layers_.count() a pixel
  };
  Rgb mean(const Tile& tile, size_t pixel) const;
  Rgb layer_mean(const Tile& tile, size_t pixel, int layer) const;
  template <class Mean>
  Image means(Mean mean_of) const;  // of each pixel that has samples: mean_of(tile, pixel)

  int width_, height_, tiles_x_;
  const FilmLayers layers_;
  std::vector<Tile> tiles_;
  std::atomic<uint64_t> version_{0};
  mutable std::mutex noise_mutex_;
  std::shared_ptr<const Image> noise_;
};

}  // namespace qray
