// A frame on the wire (docs/api.md, "Live"): a header, then the picture. Pure functions.
#pragma once

#include <optional>
#include <string_view>

#include "core/base/byte_io.h"
#include "server/live/live_session.h"

namespace qray::server {

enum class FrameEncoding : uint8_t { kRgb9e5, kJpeg, kWebp };
std::optional<FrameEncoding> frame_encoding_named(std::string_view name);  // rgb9e5, jpeg, webp

Result<Bytes> encode_frame(const ShownFrame& shown, FrameEncoding encoding);

}  // namespace qray::server
