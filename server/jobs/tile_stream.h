// The binary answer of GET .../tiles (docs/api.md, "Tiles"): RGB9E5 tiles, a CRC-32C each. Pure.
#pragma once

#include "core/base/byte_io.h"
#include "core/base/result.h"
#include "core/film/film.h"
#include "server/store/picture.h"

namespace qray::server {

Bytes encode_tiles(int width, int height, const Film::Changes& changes);

// A whole picture's answer, back to a picture of as many digits as RGB9E5 has. kCorrupt: it is
// none.
Result<Picture> decode_tiles(std::span<const uint8_t> answer);

}  // namespace qray::server
