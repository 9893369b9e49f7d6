#include "core/import/ply_header.h"

#include <algorithm>
#include <charconv>
#include <optional>

namespace qray {
namespace {

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> tokens;
  while (true) {
    const size_t begin = line.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos) return tokens;
    const size_t end = std::min(line.find_first_of(" \t\r", begin), line.size());
    tokens.push_back(line.substr(begin, end - begin));
    line.remove_prefix(end);
  }
}

std::optional<PlyType> type_of(std::string_view name) {
  static constexpr struct {
    std::string_view name, sized_name;
    PlyType type;
  } kTypes[] = {{"char", "int8", PlyType::kInt8},        {"uchar", "uint8", PlyType::kUint8},
                {"short", "int16", PlyType::kInt16},     {"ushort", "uint16", PlyType::kUint16},
                {"int", "int32", PlyType::kInt32},       {"uint", "uint32", PlyType::kUint32},
                {"float", "float32", PlyType::kFloat32}, {"double", "float64", PlyType::kFloat64}};
  for (const auto& t : kTypes)
    if (name == t.name || name == t.sized_name) return t.type;
  return std::nullopt;
}

class HeaderParser {
 public:
  HeaderParser(std::string_view text, const std::string& file) : text_(text), file_(file) {}

  PlyHeader parse() {
    if (next_line() != std::vector<std::string_view>{"ply"}) fail("expected \"ply\"");
    bool has_format = false;
    while (true) {
      const std::vector<std::string_view> line = next_line();
      if (line.empty() || line[0] == "comment" || line[0] == "obj_info") continue;
      if (line[0] == "end_header") break;
      if (line[0] == "format") {
        format(line);
        has_format = true;
      } else if (line[0] == "element") {
        element(line);
      } else if (line[0] == "property") {
        property(line);
      } else {
        fail("expected format, element, property or end_header");
      }
    }
    if (!has_format) fail("expected a \"format\" line before the header's end");
    header_.body_offset = offset_;
    return std::move(header_);
  }

 private:
  [[noreturn]] void fail(const std::string& message) const {
    fail_import(ErrorCode::kInvalid, message,
                file_ + ":" + std::to_string(std::max<size_t>(1, header_.line_count)));
  }

  std::vector<std::string_view> next_line() {
    ++header_.line_count;
    const size_t end = text_.find('\n', offset_);
    if (end == std::string_view::npos) fail("the header has no \"end_header\" line");
    const std::string_view line = text_.substr(offset_, end - offset_);
    offset_ = end + 1;
    return split(line);
  }

  void format(const std::vector<std::string_view>& line) {
    if (line.size() != 3 || line[2] != "1.0") fail("expected \"format KIND 1.0\"");
    if (line[1] == "ascii")
      header_.format = PlyFormat::kAscii;
    else if (line[1] == "binary_little_endian")
      header_.format = PlyFormat::kLittleEndian;
    else if (line[1] == "binary_big_endian")
      header_.format = PlyFormat::kBigEndian;
    else
      fail("expected ascii, binary_little_endian or binary_big_endian");
  }

  void element(const std::vector<std::string_view>& line) {
    PlyElement element;
    if (line.size() != 3) fail("expected \"element NAME COUNT\"");
    element.name = line[1];
    const char* end = line[2].data() + line[2].size();
    const auto result = std::from_chars(line[2].data(), end, element.count);
    if (result.ec != std::errc{} || result.ptr != end) fail("expected a count of elements");
    header_.elements.push_back(std::move(element));
  }

  void property(const std::vector<std::string_view>& line) {
    if (header_.elements.empty()) fail("expected an element before its properties");
    PlyProperty property;
    property.is_list = line.size() == 5 && line[1] == "list";
    if (!property.is_list && line.size() != 3)
      fail("expected \"property TYPE NAME\" or \"property list TYPE TYPE NAME\"");
    const auto type = type_of(line[line.size() - 2]);
    const auto count_type = property.is_list ? type_of(line[2]) : PlyType::kUint8;
    if (!type || !count_type) fail("expected a type such as float or uint8");
    if (*count_type == PlyType::kFloat32 || *count_type == PlyType::kFloat64)
      fail("expected an integer type for the list's length");
    property.type = *type;
    property.count_type = *count_type;
    property.name = line.back();
    header_.elements.back().properties.push_back(std::move(property));
  }

  std::string_view text_;
  const std::string& file_;
  PlyHeader header_;
  size_t offset_ = 0;
};

}  // namespace

size_t ply_type_bytes(PlyType type) {
  constexpr size_t kBytes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return kBytes[static_cast<size_t>(type)];
}

uint64_t PlyElement::min_bytes() const {
  uint64_t bytes = 0;
  for (const PlyProperty& p : properties)
    bytes += ply_type_bytes(p.is_list ? p.count_type : p.type);
  return bytes;
}

PlyHeader parse_ply_header(std::string_view text, const std::string& file) {
  return HeaderParser(text, file).parse();
}

}  // namespace qray
