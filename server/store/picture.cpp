#include "server/store/picture.h"

#include <algorithm>
#include <utility>

#include "core/base/file.h"

namespace qray::server {
namespace fs = std::filesystem;
namespace {

constexpr uint32_t kPictureMagic = 0x4d545251;  // "QRTM"
constexpr uint64_t kMaxTilesBytes = 16u << 20;

int tiles_across(int width) { return (width + Film::kTilePx - 1) / Film::kTilePx; }

Film::TileView view(const Picture& picture, int index) {
  const Picture::TileMark& mark = picture.tiles[static_cast<size_t>(index)];
  Film::TileView v{index, mark.version, mark.samples, {}};
  const TileRect rect = tile_rect(picture.image.width(), picture.image.height(), index);
  for (int y = rect.y; y < rect.y + rect.height; ++y)
    for (int x = rect.x; x < rect.x + rect.width; ++x) v.mean.push_back(picture.image.rgb(x, y));
  return v;
}

}  // namespace

size_t tile_count(int width, int height) {
  return static_cast<size_t>(tiles_across(width)) * static_cast<size_t>(tiles_across(height));
}

size_t tile_at(int width, int x, int y) {
  return static_cast<size_t>(y / Film::kTilePx * tiles_across(width) + x / Film::kTilePx);
}

TileRect tile_rect(int width, int height, int index) {
  const int x = index % tiles_across(width) * Film::kTilePx;
  const int y = index / tiles_across(width) * Film::kTilePx;
  return {x, y, std::min(Film::kTilePx, width - x), std::min(Film::kTilePx, height - y)};
}

Film::Changes Picture::tiles_since(uint64_t since, int limit) const {
  std::vector<std::pair<uint64_t, int>> changed;
  for (size_t i = 0; i < tiles.size(); ++i) {
    if (tiles[i].version > since) changed.emplace_back(tiles[i].version, static_cast<int>(i));
  }
  std::sort(changed.begin(), changed.end());
  Film::Changes changes;
  changes.cursor = std::max(since, version);
  const size_t kept = std::min(changed.size(), static_cast<size_t>(std::max(limit, 0)));
  if (kept < changed.size()) {
    changes.left_out = static_cast<int>(changed.size() - kept);
    changes.cursor = kept > 0 ? changed[kept - 1].first : since;
  }
  for (size_t i = 0; i < kept; ++i) changes.tiles.push_back(view(*this, changed[i].second));
  return changes;
}

Picture take_picture(const Film& film) {
  constexpr int kAtOnce = 64;  // tiles copied at a time
  Picture picture;
  picture.image = Image(film.width(), film.height(), 3);
  picture.tiles.resize(tile_count(film.width(), film.height()));
  Film::Changes changes;
  do {
    changes = film.tiles_since(picture.version, kAtOnce);
    picture.version = changes.cursor;
    for (const Film::TileView& tile : changes.tiles) {
      picture.tiles[static_cast<size_t>(tile.index)] = {tile.version, tile.samples};
      const TileRect rect = film.tile(tile.index);
      size_t k = 0;
      for (int y = rect.y; y < rect.y + rect.height; ++y)
        for (int x = rect.x; x < rect.x + rect.width; ++x)
          picture.image.set_rgb(x, y, tile.mean[k++]);
    }
  } while (changes.left_out > 0);
  return picture;
}

Status save_picture(const fs::path& folder, const Picture& picture, const ImageMetadata& metadata) {
  std::error_code ec;
  fs::create_directories(folder, ec);
  if (ec) return Error{ErrorCode::kIo, ec.message(), folder.string()};
  ByteWriter out;
  out.u32(kPictureMagic);
  out.u32(static_cast<uint32_t>(picture.image.width()));
  out.u32(static_cast<uint32_t>(picture.image.height()));
  out.u32(static_cast<uint32_t>(picture.tiles.size()));
  for (const Picture::TileMark& mark : picture.tiles) {
    out.u64(mark.version);
    out.u32(mark.samples);
  }
  out.u32(crc32c(out.data()));
  if (Status s = write_file_atomic(folder / "tiles.bin", out.data()); !s.ok()) return s;
  return write_image(folder / "image.exr", picture.image, metadata);
}

Result<Picture> load_picture(const fs::path& folder) {
  Result<Bytes> bytes = read_file(folder / "tiles.bin", kMaxTilesBytes);
  if (!bytes.ok()) return bytes.error();
  Result<Image> image = read_image(folder / "image.exr", kMaxPicturePixels);
  if (!image.ok()) return image.error();
  Picture picture;
  picture.image = std::move(image).value();
  const int width = picture.image.width(), height = picture.image.height();

  ByteReader in(bytes.value());
  bool good = in.u32() == kPictureMagic && in.u32() == static_cast<uint32_t>(width);
  good = in.u32() == static_cast<uint32_t>(height) && good;
  const uint32_t count = in.u32();
  good = good && picture.image.channels() == 3 && count == tile_count(width, height);
  for (uint32_t i = 0; good && i < count && in.ok(); ++i) {
    const uint64_t version = in.u64();
    picture.tiles.push_back({version, in.u32()});
    picture.version = std::max(picture.version, version);
  }
  const size_t checked = in.offset();
  const uint32_t crc = in.u32();
  if (!good || !in.ok() || in.remaining() != 0 ||
      crc != crc32c(std::span(bytes.value()).first(checked))) {
    return Error{ErrorCode::kCorrupt, "does not belong to the picture beside it",
                 (folder / "tiles.bin").string()};
  }
  return picture;
}

}  // namespace qray::server
