#include "core/base/file_names.h"

#include <algorithm>
#include <cstdint>

namespace qray {
namespace {

// RFC 3629: no overlong forms, no surrogates, nothing above U+10FFFF.
bool is_utf8(std::string_view text) {
  for (size_t i = 0; i < text.size();) {
    const auto at = [&](size_t k) { return static_cast<uint8_t>(text[k]); };
    const uint8_t first = at(i);
    const size_t more = first < 0x80 ? 0 : first < 0xe0 ? 1 : first < 0xf0 ? 2 : 3;
    if ((first >= 0x80 && first < 0xc2) || first > 0xf4 || i + more >= text.size()) return false;
    for (size_t k = 1; k <= more; ++k)
      if ((at(i + k) & 0xc0) != 0x80) return false;
    if ((first == 0xe0 && at(i + 1) < 0xa0) || (first == 0xed && at(i + 1) > 0x9f) ||
        (first == 0xf0 && at(i + 1) < 0x90) || (first == 0xf4 && at(i + 1) > 0x8f))
      return false;
    i += more + 1;
  }
  return true;
}

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c + 32);
  return out;
}

std::optional<std::string> fault_of(std::string_view name) {
  if (name.empty()) return "expected a file's name, got an empty one";
  if (name.size() > FileNames::kMaxBytes)
    return "expected a name of at most " + std::to_string(FileNames::kMaxBytes) + " bytes";
  if (!is_utf8(name)) return "expected a name in UTF-8";
  if (std::any_of(name.begin(), name.end(),
                  [](char c) { return static_cast<uint8_t>(c) < 32 || c == 127; }))
    return "expected a name without control characters";
  if (name.find('\\') != std::string_view::npos)
    return "expected / between the parts of a name, got a backslash";
  if (name.front() == '/') return "expected a relative name, got one that starts with /";
  size_t depth = 1;
  for (size_t begin = 0; begin <= name.size(); ++depth) {
    const size_t end = std::min(name.find('/', begin), name.size());
    const std::string_view part = name.substr(begin, end - begin);
    if (part.empty() || part == "." || part == "..")
      return "expected a name without empty parts, . and ..";
    if (depth > FileNames::kMaxDepth)
      return "expected at most " + std::to_string(FileNames::kMaxDepth) + " parts in a name";
    begin = end + 1;
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> FileNames::clash(std::string_view name) {
  const auto known = known_.find(lower(name));
  if (known != known_.end())
    return "is the same name as \"" + known->second.name + "\" where case is not told apart";
  for (size_t slash = name.find('/'); slash != std::string_view::npos;
       slash = name.find('/', slash + 1)) {
    const std::string_view folder = name.substr(0, slash);
    const auto above = known_.find(lower(folder));
    if (above != known_.end() && above->second.is_file)
      return "lies below \"" + above->second.name + "\", which is a file";
  }
  return std::nullopt;
}

std::optional<std::string> FileNames::add(std::string_view name) {
  if (std::optional<std::string> fault = fault_of(name)) return fault;
  if (std::optional<std::string> fault = clash(name)) return fault;
  if (++files_ > kMost) return "expected at most " + std::to_string(kMost) + " files";
  for (size_t slash = name.find('/'); slash != std::string_view::npos;
       slash = name.find('/', slash + 1))
    known_.try_emplace(lower(name.substr(0, slash)),
                       Known{std::string(name.substr(0, slash)), false});
  known_.emplace(lower(name), Known{std::string(name), true});
  return std::nullopt;
}

}  // namespace qray
