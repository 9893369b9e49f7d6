#include "core/import/ply.h"

#include <algorithm>
#include <bit>
#include <charconv>

#include "core/base/file.h"
#include "core/image/tonemap.h"
#include "core/import/ply_header.h"
#include "core/import/polygon.h"

namespace qray {
namespace {

constexpr uint64_t kMaxPlyBytes = uint64_t{1} << 30;
constexpr uint64_t kMaxFaceCorners = 1024;  // of one polygon

// The body's numbers in order, as doubles (every type fits exactly).
class ValueSource {
 public:
  ValueSource(std::string_view text, const PlyHeader& header, const std::string& file)
      : text_(text),
        format_(header.format),
        file_(file),
        offset_(header.body_offset),
        line_(header.line_count + 1) {}

  double next(PlyType type) { return format_ == PlyFormat::kAscii ? ascii() : binary(type); }

  [[noreturn]] void fail(const std::string& message, ErrorCode code = ErrorCode::kInvalid) const {
    const bool ascii = format_ == PlyFormat::kAscii;
    fail_import(code, message,
                file_ + (ascii ? ":" + std::to_string(line_)
                               : " at byte " + std::to_string(value_offset_)));
  }
  size_t remaining() const { return text_.size() - offset_; }

 private:
  double ascii() {
    while (offset_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[offset_])))
      if (text_[offset_++] == '\n') ++line_;
    size_t end = offset_;
    while (end < text_.size() && !std::isspace(static_cast<unsigned char>(text_[end]))) ++end;
    std::string_view token = text_.substr(offset_, end - offset_);
    if (token.empty()) fail("the file ends too early, expected a number", ErrorCode::kCorrupt);
    offset_ = end;
    const std::string_view shown = token.substr(0, 40);
    if (token.starts_with('+')) token.remove_prefix(1);
    double value = 0;
    const auto [stop, error] = std::from_chars(token.data(), token.data() + token.size(), value);
    if (error != std::errc{} || stop != token.data() + token.size())
      fail("expected a number, got \"" + std::string(shown) + "\"");
    return value;
  }

  double binary(PlyType type) {
    value_offset_ = offset_;
    const size_t bytes = ply_type_bytes(type);
    if (bytes > remaining())
      fail("the file ends too early, expected a number", ErrorCode::kCorrupt);
    uint64_t bits = 0;
    for (size_t i = 0; i < bytes; ++i) {
      const size_t at = format_ == PlyFormat::kBigEndian ? bytes - 1 - i : i;
      bits |= static_cast<uint64_t>(static_cast<uint8_t>(text_[offset_ + at])) << (8 * i);
    }
    offset_ += bytes;
    switch (type) {
      case PlyType::kInt8:
        return static_cast<int8_t>(bits);
      case PlyType::kInt16:
        return static_cast<int16_t>(bits);
      case PlyType::kInt32:
        return static_cast<int32_t>(bits);
      case PlyType::kFloat32:
        return std::bit_cast<float>(static_cast<uint32_t>(bits));
      case PlyType::kFloat64:
        return std::bit_cast<double>(bits);
      default:
        return static_cast<double>(bits);  // unsigned
    }
  }

  std::string_view text_;
  PlyFormat format_;
  const std::string& file_;
  size_t offset_;
  size_t value_offset_ = 0;  // of the newest binary value
  size_t line_;
};

class MeshReader {
 public:
  MeshReader(const PlyHeader& header, ValueSource& source, const SceneLimits& limits,
             const std::string& file)
      : header_(header), source_(source), limits_(limits), file_(file) {}

  Mesh read() {
    check_sizes();
    bool has_vertices = false, has_faces = false;
    for (const PlyElement& element : header_.elements) {
      if (element.name == "vertex") {
        read_vertices(element);
        has_vertices = true;
      } else if (element.name == "face") {
        if (!has_vertices) source_.fail("expected the vertices before the faces");
        read_faces(element);
        has_faces = true;
      } else {
        skip(element);
      }
    }
    if (!has_vertices || !has_faces)
      fail_import(ErrorCode::kInvalid, "expected elements \"vertex\" and \"face\"", file_);
    finish_normals();
    return std::move(mesh_);
  }

 private:
  // Counts that the file is too short for are refused before anything is allocated.
  void check_sizes() const {
    uint64_t left = source_.remaining();
    for (const PlyElement& element : header_.elements) {
      // An ascii number takes a digit and a space, the last one of the file no space.
      const uint64_t each =
          header_.format == PlyFormat::kAscii ? 2 * element.properties.size() : element.min_bytes();
      const uint64_t slack = header_.format == PlyFormat::kAscii ? 1 : 0;
      if (each == 0 || element.count > (left + slack) / each) {
        if (element.count == 0) continue;
        fail_import(ErrorCode::kCorrupt,
                    "has " + std::to_string(left) + " bytes left, too few for " +
                        std::to_string(element.count) + " of \"" + element.name + "\"",
                    file_);
      }
      left -= std::min(left, element.count * each);
    }
  }

  // The index of the first property with one of these names; -1 when there is none.
  static int find(const PlyElement& element, std::initializer_list<std::string_view> names) {
    for (const std::string_view name : names)
      for (size_t i = 0; i < element.properties.size(); ++i)
        if (element.properties[i].name == name) return static_cast<int>(i);
    return -1;
  }

  double value(const PlyProperty& property) {
    if (!property.is_list) return source_.next(property.type);
    const double count = source_.next(property.count_type);
    for (double i = 0; i < count; ++i) source_.next(property.type);
    return 0;
  }

  void read_vertices(const PlyElement& element) {
    std::vector<float> row(element.properties.size());
    const auto at = [&row](int i) { return row[static_cast<size_t>(i)]; };
    const int x = find(element, {"x"}), y = find(element, {"y"}), z = find(element, {"z"});
    const int nx = find(element, {"nx"}), ny = find(element, {"ny"}), nz = find(element, {"nz"});
    const int u = find(element, {"u", "s", "texture_u"});
    const int v = find(element, {"v", "t", "texture_v"});
    const std::array<int, 3> rgb = {find(element, {"red", "r"}), find(element, {"green", "g"}),
                                    find(element, {"blue", "b"})};
    const bool colored = *std::min_element(rgb.begin(), rgb.end()) >= 0;
    // Bytes are display-encoded, as programs write them; numbers are linear light.
    const auto color = [&](size_t c) {
      const PlyType type = element.properties[static_cast<size_t>(rgb[c])].type;
      const float stored = at(rgb[c]);
      if (type == PlyType::kUint8) return srgb_to_linear(std::clamp(stored / 255, 0.0f, 1.0f));
      return std::clamp(type == PlyType::kUint16 ? stored / 65535 : stored, 0.0f, 1.0f);
    };
    if (x < 0 || y < 0 || z < 0)
      fail_import(ErrorCode::kInvalid, "expected vertex properties x, y and z", file_);
    for (uint64_t i = 0; i < element.count; ++i) {
      for (size_t p = 0; p < row.size(); ++p) {
        const double number = value(element.properties[p]);
        // A position of any size is judged by validate(); here only the conversion must be defined.
        row[p] = static_cast<float>(std::clamp(number, -1e30, 1e30));
      }
      const Vec3 position{at(x), at(y), at(z)};
      if (!is_finite(position)) source_.fail("expected a finite position");
      mesh_.positions.push_back(position);
      if (nx >= 0 && ny >= 0 && nz >= 0) mesh_.normals.push_back({at(nx), at(ny), at(nz)});
      if (u >= 0 && v >= 0) mesh_.uvs.push_back({at(u), at(v)});
      if (colored) mesh_.colors.push_back({color(0), color(1), color(2)});
    }
  }

  void read_faces(const PlyElement& element) {
    const int list = find(element, {"vertex_indices", "vertex_index"});
    if (list < 0 || !element.properties[static_cast<size_t>(list)].is_list)
      fail_import(ErrorCode::kInvalid, "expected a face property list vertex_indices", file_);
    for (uint64_t i = 0; i < element.count; ++i) {
      for (size_t p = 0; p < element.properties.size(); ++p) {
        if (p == static_cast<size_t>(list))
          read_polygon(element.properties[p]);
        else
          value(element.properties[p]);
      }
      if (mesh_.triangles.size() > limits_.max_triangles) {
        source_.fail("expected at most " + std::to_string(limits_.max_triangles) + " triangles",
                     ErrorCode::kTooLarge);
      }
    }
  }

  void read_polygon(const PlyProperty& property) {
    const double count = source_.next(property.count_type);
    if (!(count >= 0 && count <= kMaxFaceCorners))
      source_.fail("expected at most " + std::to_string(kMaxFaceCorners) + " corners of a face");
    corners_.clear();
    positions_.clear();
    for (int i = 0; i < static_cast<int>(count); ++i) {
      const double number = source_.next(property.type);
      if (!(number >= 0 && number < static_cast<double>(mesh_.positions.size()))) {
        source_.fail("expected a vertex index below " + std::to_string(mesh_.positions.size()));
      }
      corners_.push_back(static_cast<uint32_t>(number));
      positions_.push_back(mesh_.positions[corners_.back()]);
    }
    if (corners_.size() == 3) mesh_.triangles.push_back({corners_[0], corners_[1], corners_[2]});
    if (corners_.size() <= 3) return;                     // points and edges are no surface
    if (corners_.size() == 4 && is_convex(positions_)) {  // as other readers cut it
      mesh_.triangles.push_back({corners_[0], corners_[1], corners_[2]});
      mesh_.triangles.push_back({corners_[0], corners_[2], corners_[3]});
      return;
    }
    for (const auto& [a, b, c] : cut_polygon(positions_))
      mesh_.triangles.push_back({corners_[a], corners_[b], corners_[c]});
  }

  // Four corners that the diagonal from the first parts into two triangles that face one way.
  static bool is_convex(const std::vector<Vec3>& p) {
    return dot(cross(p[1] - p[0], p[2] - p[0]), cross(p[2] - p[0], p[3] - p[0])) > 0;
  }

  void skip(const PlyElement& element) {
    for (uint64_t i = 0; i < element.count; ++i)
      for (const PlyProperty& property : element.properties) value(property);
  }

  // A mesh with a normal without length is drawn flat.
  void finish_normals() {
    for (Vec3& n : mesh_.normals) {
      const float norm = length(n);
      if (!(norm > 0 && std::isfinite(norm))) {
        mesh_.normals.clear();
        return;
      }
      n = n / norm;
    }
  }

  const PlyHeader& header_;
  ValueSource& source_;
  const SceneLimits& limits_;
  const std::string& file_;
  Mesh mesh_;
  std::vector<uint32_t> corners_;  // of the polygon that is read
  std::vector<Vec3> positions_;
};

}  // namespace

Mesh read_ply(const std::filesystem::path& path, const SceneLimits& limits) {
  const std::string file = path.filename();
  const Result<Bytes> bytes = read_file(path, kMaxPlyBytes);
  if (!bytes.ok()) throw ImportFailure{bytes.error()};
  const std::string_view text(reinterpret_cast<const char*>(bytes.value().data()),
                              bytes.value().size());
  const PlyHeader header = parse_ply_header(text, file);
  ValueSource source(text, header, file);
  return MeshReader(header, source, limits, file).read();
}

}  // namespace qray
