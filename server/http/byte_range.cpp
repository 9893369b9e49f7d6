#include "server/http/byte_range.h"

#include <algorithm>
#include <charconv>
#include <cstdint>

namespace qray::server {
namespace {

// Digits alone; a number that is too large is the largest.
std::optional<uint64_t> number_of(std::string_view text) {
  if (text.empty() || text.find_first_not_of("0123456789") != std::string_view::npos) return {};
  uint64_t number = UINT64_MAX;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

}  // namespace

std::optional<ByteRange> parse_range(std::string_view text, size_t whole) {
  constexpr std::string_view kUnit = "bytes=";
  const size_t dash = text.find('-');
  if (!text.starts_with(kUnit) || dash == std::string_view::npos) return {};
  const std::string_view first = text.substr(kUnit.size(), dash - kUnit.size());
  const std::string_view last = text.substr(dash + 1);
  const std::optional<uint64_t> begin = number_of(first), end = number_of(last);
  if ((!begin && !first.empty()) || (!end && !last.empty()) || (!begin && !end)) return {};
  if (!begin) {
    const size_t size = std::min<uint64_t>(*end, whole);
    return ByteRange{whole - size, size};
  }
  if (end && *end < *begin) return {};
  if (*begin >= whole) return ByteRange{};
  const uint64_t most = whole - *begin;
  return ByteRange{*begin, end ? std::min(*end - *begin, most - 1) + 1 : most};
}

}  // namespace qray::server
