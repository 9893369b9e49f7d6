#include "core/film/film.h"

#include <algorithm>

#include "core/base/check.h"

namespace qray {

Film::Film(int width, int height)
    : width_(width),
      height_(height),
      tiles_x_((width + kTilePx - 1) / kTilePx),
      tiles_(static_cast<size_t>(tiles_x_) *
             static_cast<size_t>((height + kTilePx - 1) / kTilePx)) {
  QRAY_CHECK(width > 0 && height > 0);
}

TileRect Film::tile(int index) const {
  const int x = index % tiles_x_ * kTilePx, y = index / tiles_x_ * kTilePx;
  return {x, y, std::min(kTilePx, width_ - x), std::min(kTilePx, height_ - y)};
}

void Film::add(int index, std::span<const Rgb> sums, uint32_t samples) {
  Tile& tile = tiles_[static_cast<size_t>(index)];
  std::lock_guard lock(tile.mutex);
  if (tile.sums.empty()) tile.sums.resize(sums.size());
  QRAY_CHECK(tile.sums.size() == sums.size());
  for (size_t i = 0; i < sums.size(); ++i) tile.sums[i] += sums[i];
  tile.samples += samples;
  tile.weight += static_cast<float>(samples);
  tile.version = version_.fetch_add(1, std::memory_order_acq_rel) + 1;
}

void Film::fade(float keep) {
  for (Tile& tile : tiles_) {
    std::lock_guard lock(tile.mutex);
    for (Rgb& sum : tile.sums) sum *= keep;
    tile.weight *= keep;
  }
}

Film::TileView Film::view(int index) const {
  const Tile& tile = tiles_[static_cast<size_t>(index)];
  TileView v;
  v.index = index;
  std::lock_guard lock(tile.mutex);
  v.version = tile.version;
  v.samples = tile.samples;
  v.mean.reserve(tile.sums.size());
  const float scale = tile.weight > 0 ? 1 / tile.weight : 0.0f;
  for (Rgb sum : tile.sums) v.mean.push_back(sum * scale);
  return v;
}

Film::Changes Film::tiles_since(uint64_t since, int limit) const {
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
  for (size_t i = 0; i < kept; ++i) changes.tiles.push_back(view(changed[i].second));
  return changes;
}

Image Film::develop() const {
  Image image(width_, height_, 3);
  for (int i = 0; i < tile_count(); ++i) {
    const TileView v = view(i);
    if (v.mean.empty()) continue;
    const TileRect rect = tile(i);
    size_t k = 0;
    for (int y = 0; y < rect.height; ++y)
      for (int x = 0; x < rect.width; ++x) image.set_rgb(rect.x + x, rect.y + y, v.mean[k++]);
  }
  return image;
}

}  // namespace qray
