#include "server/tile_stream.h"

#include "core/image/rgb9e5.h"
#include "server/store/picture.h"

namespace qray::server {

Bytes encode_tiles(int width, int height, const Film::Changes& changes) {
  ByteWriter out;
  for (char c : {'Q', 'R', 'T', '1'}) out.u8(static_cast<uint8_t>(c));
  out.u32(static_cast<uint32_t>(width));
  out.u32(static_cast<uint32_t>(height));
  out.u64(changes.cursor);
  out.u32(static_cast<uint32_t>(changes.tiles.size()));
  out.u32(static_cast<uint32_t>(changes.left_out));
  for (const Film::TileView& tile : changes.tiles) {
    const TileRect rect = tile_rect(width, height, tile.index);
    ByteWriter pixels;
    for (Rgb c : tile.mean) pixels.u32(pack_rgb9e5(c));
    out.u32(static_cast<uint32_t>(rect.x));
    out.u32(static_cast<uint32_t>(rect.y));
    out.u32(static_cast<uint32_t>(rect.width));
    out.u32(static_cast<uint32_t>(rect.height));
    out.u32(tile.samples);
    out.u32(crc32c(pixels.data()));
    out.bytes(pixels.data());
  }
  return out.take();
}

}  // namespace qray::server
