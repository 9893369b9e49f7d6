#include "server/tile_stream.h"

#include "core/image/rgb9e5.h"
#include "server/store/picture.h"

namespace qray::server {
namespace {

// Little-endian. Not through ByteWriter, whose growth byte by byte costs as much as the packing.
Bytes packed_pixels(std::span<const Rgb> colors) {
  Bytes bytes(4 * colors.size());
  for (size_t i = 0; i < colors.size(); ++i) {
    const uint32_t packed = pack_rgb9e5(colors[i]);
    for (size_t k = 0; k < 4; ++k) bytes[4 * i + k] = static_cast<uint8_t>(packed >> (8 * k));
  }
  return bytes;
}

}  // namespace

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
    const Bytes pixels = packed_pixels(tile.mean);
    out.u32(static_cast<uint32_t>(rect.x));
    out.u32(static_cast<uint32_t>(rect.y));
    out.u32(static_cast<uint32_t>(rect.width));
    out.u32(static_cast<uint32_t>(rect.height));
    out.u32(tile.samples);
    out.u32(crc32c(pixels));
    out.bytes(pixels);
  }
  return out.take();
}

}  // namespace qray::server
