#include "server/jobs/tile_stream.h"

#include "core/image/rgb9e5.h"

namespace qray::server {
namespace {

// Little-endian. Not through ByteWriter, whose growth byte by byte costs as much as the packing.
Bytes packed_pixels(std::span<const Rgb> colors) {
  Bytes bytes(4 * colors.size());
  for (size_t i = 0; i < colors.size(); ++i) put_rgb9e5(colors[i], &bytes[4 * i]);
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

Result<Picture> decode_tiles(std::span<const uint8_t> answer) {
  const Error wrong{ErrorCode::kCorrupt, "is no answer of tiles", ""};
  ByteReader in(answer);
  bool good = in.u8() == 'Q' && in.u8() == 'R' && in.u8() == 'T' && in.u8() == '1';
  const uint32_t width = in.u32(), height = in.u32();
  const uint64_t cursor = in.u64();
  const uint32_t count = in.u32();
  in.u32();  // left out
  good = good && width > 0 && height > 0 && uint64_t{width} * height <= kMaxPicturePixels;
  if (!good || !in.ok() || uint64_t{width} * height * 4 > answer.size()) return wrong;
  Picture picture;
  picture.image = Image(static_cast<int>(width), static_cast<int>(height), 3);
  picture.tiles.resize(tile_count(picture.image.width(), picture.image.height()));
  picture.version = cursor;
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t x = in.u32(), y = in.u32(), w = in.u32(), h = in.u32(), samples = in.u32();
    in.u32();  // checksum: whoever kept the answer has one of all
    if (!in.ok() || x >= width || y >= height || w > width - x || h > height - y) return wrong;
    picture.tiles[tile_at(picture.image.width(), static_cast<int>(x), static_cast<int>(y))] = {
        cursor, samples};
    for (uint32_t py = y; py < y + h; ++py)
      for (uint32_t px = x; px < x + w; ++px)
        picture.image.set_rgb(static_cast<int>(px), static_cast<int>(py), unpack_rgb9e5(in.u32()));
  }
  if (!in.ok() || in.remaining() != 0) return wrong;
  return picture;
}

}  // namespace qray::server
