#include "core/film/film.h"

#include <algorithm>

#include "core/base/check.h"

namespace qray {

Film::Film(int width, int height, FilmLayers layers)
    : width_(width),
      height_(height),
      tiles_x_((width + kTilePx - 1) / kTilePx),
      layers_(layers),
      tiles_(static_cast<size_t>(tiles_x_) *
             static_cast<size_t>((height + kTilePx - 1) / kTilePx)) {
  QRAY_CHECK(width > 0 && height > 0);
}

TileRect Film::tile(int index) const {
  const int x = index % tiles_x_ * kTilePx, y = index / tiles_x_ * kTilePx;
  return {x, y, std::min(kTilePx, width_ - x), std::min(kTilePx, height_ - y)};
}

void Film::add(int index, std::span<const Rgb> sums, uint32_t samples,
               std::span<const uint32_t> counts, std::span<const Rgb> seen,
               std::span<const Rgb> layers, uint32_t each) {
  Tile& tile = tiles_[static_cast<size_t>(index)];
  std::lock_guard lock(tile.mutex);
  if (tile.sums.empty()) {
    tile.sums.resize(sums.size());
    tile.weights.resize(sums.size());
    tile.seen.resize(sums.size());
    tile.layers.resize(sums.size() * static_cast<size_t>(layers_.count()));
  }
  QRAY_CHECK(tile.sums.size() == sums.size() && (counts.empty() || counts.size() == sums.size()) &&
             (seen.empty() || seen.size() == sums.size()) && layers.size() == tile.layers.size());
  const size_t layer_count = static_cast<size_t>(layers_.count());
  for (size_t i = 0; i < sums.size(); ++i) {
    const uint32_t count = counts.empty() ? samples : counts[i];
    if (count == 0) continue;
    const uint32_t weight = each > 0 ? each : count;
    const float scale = static_cast<float>(weight) / static_cast<float>(count);
    tile.sums[i] += sums[i] * scale;
    tile.weights[i] += static_cast<float>(weight);
    if (!seen.empty()) tile.seen[i] += seen[i] * scale;
    for (size_t l = i * layer_count; l < (i + 1) * layer_count; ++l)
      tile.layers[l] += layers[l] * scale;
  }
  tile.samples += samples;
  tile.version = version_.fetch_add(1, std::memory_order_acq_rel) + 1;
}

void Film::fade(float keep) {
  for (Tile& tile : tiles_) {
    std::lock_guard lock(tile.mutex);
    for (Rgb& sum : tile.sums) sum *= keep;
    for (Rgb& sum : tile.seen) sum *= keep;
    for (Rgb& sum : tile.layers) sum *= keep;
    for (float& weight : tile.weights) weight *= keep;
  }
}

Rgb Film::mean(const Tile& tile, size_t pixel) const {
  const float weight = tile.weights[pixel];
  if (!(weight > 0)) return {};
  if (layers_.groups == 0) return tile.sums[pixel] * (1 / weight);
  Rgb sum;
  for (int g = 0; g < layers_.groups; ++g) sum += layer_mean(tile, pixel, layers_.group(g));
  return sum;
}

Rgb Film::layer_mean(const Tile& tile, size_t pixel, int layer) const {
  const float weight = tile.weights[pixel];
  if (!(weight > 0)) return {};
  const size_t at = pixel * static_cast<size_t>(layers_.count()) + static_cast<size_t>(layer);
  return tile.layers[at] * (1 / weight);
}

Film::TileView Film::tile_view(int index, std::optional<int> layer) const {
  const Tile& tile = tiles_[static_cast<size_t>(index)];
  TileView v;
  v.index = index;
  std::lock_guard lock(tile.mutex);
  v.version = tile.version;
  v.samples = tile.samples;
  v.mean.reserve(tile.sums.size());
  for (size_t i = 0; i < tile.sums.size(); ++i)
    v.mean.push_back(layer ? layer_mean(tile, i, *layer) : mean(tile, i));
  return v;
}

Film::Changes Film::tiles_since(uint64_t since, int limit, std::optional<int> layer) const {
  // Every version up to `newest` is set, or will be before its tile's lock can be taken; later ones
  // wait for the next call, so that the cursor passes over none.
  const uint64_t newest = version();
  std::vector<std::pair<uint64_t, int>> changed;
  for (int i = 0; i < tile_count(); ++i) {
    const Tile& tile = tiles_[static_cast<size_t>(i)];
    std::lock_guard lock(tile.mutex);
    if (tile.version > since && tile.version <= newest) changed.emplace_back(tile.version, i);
  }
  std::sort(changed.begin(), changed.end());
  Changes changes;
  changes.cursor = std::max(since, newest);
  const size_t kept = std::min(changed.size(), static_cast<size_t>(std::max(limit, 0)));
  if (kept < changed.size()) {
    changes.left_out = static_cast<int>(changed.size() - kept);
    changes.cursor = kept > 0 ? changed[kept - 1].first : since;
  }
  for (size_t i = 0; i < kept; ++i) changes.tiles.push_back(tile_view(changed[i].second, layer));
  return changes;
}

void Film::set_noise(Image noise) {
  auto shared = std::make_shared<const Image>(std::move(noise));
  std::lock_guard lock(noise_mutex_);
  noise_ = std::move(shared);
}

std::shared_ptr<const Image> Film::noise() const {
  std::lock_guard lock(noise_mutex_);
  return noise_;
}

void Film::save_state(SnapshotWriter& out) const {
  out(width_, height_, layers_.bounces, layers_.groups, version());
  for (const Tile& tile : tiles_) {
    std::lock_guard lock(tile.mutex);
    out(tile.samples, tile.sums, tile.weights, tile.seen, tile.layers);
  }
}

void Film::load_state(SnapshotReader& in) {
  constexpr int kEpochBits = 32;  // versions between two loads
  int width = 0, height = 0;
  FilmLayers layers;
  uint64_t version = 0;
  in(width, height, layers.bounces, layers.groups, version);
  if (width != width_ || height != height_ || !(layers == layers_)) return in.fail();
  version = ((version >> kEpochBits) + 1) << kEpochBits;
  for (int i = 0; i < tile_count(); ++i) {
    Tile& tile = tiles_[static_cast<size_t>(i)];
    std::lock_guard lock(tile.mutex);
    in(tile.samples, tile.sums, tile.weights, tile.seen, tile.layers);
    const TileRect rect = this->tile(i);
    const size_t pixels = static_cast<size_t>(rect.width) * static_cast<size_t>(rect.height);
    if (tile.sums.size() != tile.weights.size() || tile.sums.size() != tile.seen.size() ||
        tile.layers.size() != tile.sums.size() * static_cast<size_t>(layers_.count()) ||
        (!tile.sums.empty() && tile.sums.size() != pixels))
      in.fail();
    if (!in.ok()) return;
    if (!tile.sums.empty()) tile.version = ++version;
  }
  version_.store(version, std::memory_order_release);
}

Image Film::develop() const {
  return means([this](const Tile& tile, size_t pixel) { return mean(tile, pixel); });
}

Image Film::seen() const {
  return means(
      [](const Tile& tile, size_t pixel) { return tile.seen[pixel] * (1 / tile.weights[pixel]); });
}

Image Film::layer(int index) const {
  QRAY_CHECK(index >= 0 && index < layers_.count());
  return means(
      [this, index](const Tile& tile, size_t pixel) { return layer_mean(tile, pixel, index); });
}

Image Film::indirect() const {
  QRAY_CHECK(layers_.bounces > 1);
  return means([this](const Tile& tile, size_t pixel) {
    Rgb sum;
    for (int i = 1; i < layers_.bounces; ++i) sum += layer_mean(tile, pixel, i);
    return sum;
  });
}

template <class Mean>
Image Film::means(Mean mean_of) const {
  Image image(width_, height_, 3);
  for (int i = 0; i < tile_count(); ++i) {
    const Tile& tile = tiles_[static_cast<size_t>(i)];
    std::lock_guard lock(tile.mutex);
    if (tile.sums.empty()) continue;
    const TileRect rect = this->tile(i);
    size_t k = 0;
    for (int y = 0; y < rect.height; ++y)
      for (int x = 0; x < rect.width; ++x, ++k)
        if (tile.weights[k] > 0) image.set_rgb(rect.x + x, rect.y + y, mean_of(tile, k));
  }
  return image;
}

}  // namespace qray
