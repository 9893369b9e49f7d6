// The part of an answer that a client asks for by Range (RFC 9110, section 14). Pure functions.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace qray::server {

struct ByteRange {
  size_t begin = 0, size = 0;  // size 0: nothing of it is there
};

// Of "bytes=0-99", "bytes=100-" or "bytes=-50", in `whole` bytes. None: it is no such range, and
// the whole is the answer.
std::optional<ByteRange> parse_range(std::string_view text, size_t whole);

}  // namespace qray::server
