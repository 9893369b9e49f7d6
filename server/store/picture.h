// The picture of a job that has ended: what its film held, tile versions included, so that readers
// go on with the cursors they have. Plain data and its two files.
#pragma once

#include <filesystem>
#include <memory>

#include "core/film/film.h"
#include "core/image/image_io.h"

namespace qray::server {

constexpr int64_t kMaxPicturePixels = int64_t{8192} * 8192;

struct Picture {
  struct TileMark {
    uint64_t version = 0;  // 0: nothing rendered
    uint32_t samples = 0;  // a pixel
  };
  Image image;                  // means; black where there is no sample
  std::vector<TileMark> tiles;  // in the film's order
  uint64_t version = 0;         // the newest of the tiles

  size_t bytes() const { return image.data().size_bytes() + tiles.size() * sizeof(TileMark); }
  // As Film::tiles_since.
  Film::Changes tiles_since(uint64_t since, int limit) const;
};

Picture take_picture(const Film& film);
// Tiles of a picture, as Film has them.
size_t tile_count(int width, int height);
size_t tile_at(int width, int x, int y);  // that holds a pixel
TileRect tile_rect(int width, int height, int index);

// <folder>/image.exr with the metadata, and <folder>/tiles.bin (magic "QRTM", u32 width, height and
// count, then u64 version and u32 samples a tile, CRC-32C of all before).
Status save_picture(const std::filesystem::path& folder, const Picture& picture,
                    const ImageMetadata& metadata);
Result<Picture> load_picture(const std::filesystem::path& folder);

}  // namespace qray::server
