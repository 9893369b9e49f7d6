// The binary answer of GET .../tiles (docs/api.md, "Tiles"): RGB9E5 tiles, a CRC-32C each. Pure.
#pragma once

#include "core/base/byte_io.h"
#include "core/film/film.h"

namespace qray::server {

Bytes encode_tiles(int width, int height, const Film::Changes& changes);

}  // namespace qray::server
