#include "core/import/obj.h"

#include <tiny_obj_loader.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <set>
#include <sstream>
#include <unordered_map>

#include "core/base/file.h"
#include "core/image/tonemap.h"
#include "core/import/import_failure.h"
#include "core/import/mtl.h"
#include "core/import/polygon.h"
#include "core/import/scene_folder.h"
#include "core/math/hash.h"

namespace qray {
namespace {

constexpr uint64_t kMaxObjBytes = uint64_t{1} << 30;
constexpr uint64_t kMaxMtlBytes = uint64_t{16} << 20;
constexpr size_t kMaxPolygonCorners =
    1024;  // of one polygon: cutting ears off takes quadratic time
constexpr MaterialId kGrey{std::numeric_limits<uint32_t>::max()};  // until all others are known

std::string_view next_token(std::string_view& line) {
  const size_t begin = line.find_first_not_of(" \t");
  if (begin == std::string_view::npos) {
    line = {};
    return {};
  }
  const size_t end = std::min(line.find_first_of(" \t", begin), line.size());
  const std::string_view token = line.substr(begin, end - begin);
  line.remove_prefix(end);
  return token;
}

// Without white space around it.
std::string trimmed(std::string_view line) {
  const size_t begin = line.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return std::string(line.substr(begin, line.find_last_not_of(" \t") + 1 - begin));
}

template <class T>
bool parse(std::string_view token, T& value) {
  if (token.starts_with('+')) token.remove_prefix(1);
  const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), value);
  return error == std::errc{} && end == token.data() + token.size();
}

// What the lines so far have listed.
struct Lists {
  std::vector<Vec3> positions, normals;
  std::vector<Vec2> uvs;
  std::map<size_t, Rgb> colors;  // of those positions that have one
};

// Of a face: places in the lists; -1: none.
struct Corner {
  int64_t position = -1, uv = -1, normal = -1;
  bool operator==(const Corner&) const = default;
};
struct CornerHash {
  size_t operator()(const Corner& c) const {
    const auto u = [](int64_t v) { return static_cast<uint64_t>(v); };
    return hash_combine(u(c.position) << 32 ^ u(c.normal), u(c.uv));
  }
};

// One mesh of the corners of one group and material, equal corners shared.
class MeshBuilder {
 public:
  MeshBuilder(const Lists& lists, const std::string& name, MaterialId material) : lists_(lists) {
    mesh_.name = name;
    mesh_.material = material;
  }

  void add_triangle(const Corner& a, const Corner& b, const Corner& c) {
    mesh_.triangles.push_back({vertex(a), vertex(b), vertex(c)});
  }

  Mesh finish() {
    if (!has_normals_) mesh_.normals.clear();
    if (!has_uvs_) mesh_.uvs.clear();
    if (!has_colors_) mesh_.colors.clear();
    return std::move(mesh_);
  }

 private:
  uint32_t vertex(const Corner& c) {
    const auto [it, is_new] =
        vertices_.try_emplace(c, static_cast<uint32_t>(mesh_.positions.size()));
    if (!is_new) return it->second;
    mesh_.positions.push_back(lists_.positions[static_cast<size_t>(c.position)]);
    Vec3 normal;
    if (c.normal >= 0) normal = lists_.normals[static_cast<size_t>(c.normal)];
    const float norm = length(normal);
    // A mesh with a normal missing or without length is drawn flat.
    has_normals_ = has_normals_ && norm > 0 && std::isfinite(norm);
    mesh_.normals.push_back(normal / norm);
    if (!lists_.colors.empty()) {
      const auto color = lists_.colors.find(static_cast<size_t>(c.position));
      has_colors_ = has_colors_ || color != lists_.colors.end();
      mesh_.colors.push_back(color == lists_.colors.end() ? Rgb{1.0f} : color->second);
    }
    mesh_.uvs.push_back(c.uv >= 0 ? lists_.uvs[static_cast<size_t>(c.uv)] : Vec2{});
    has_uvs_ = has_uvs_ || c.uv >= 0;
    return it->second;
  }

  const Lists& lists_;
  Mesh mesh_;
  bool has_normals_ = true, has_uvs_ = false, has_colors_ = false;
  std::unordered_map<Corner, uint32_t, CornerHash> vertices_;
};

class ObjReader {
 public:
  ObjReader(const std::filesystem::path& path, const SceneLimits& limits)
      : file_(path.filename()), folder_(scene_folder(path)), limits_(limits) {}

  void count_line() { ++line_number_; }
  void read_line(std::string_view line) {
    ++line_number_;
    const std::string_view keyword = next_token(line);
    if (keyword == "v") {
      read_position(line);
    } else if (keyword == "vt") {
      const std::array<float, 3> v = numbers(line, 1);
      lists_.uvs.push_back({v[0], v[1]});
    } else if (keyword == "vn") {
      const std::array<float, 3> v = numbers(line, 3);
      lists_.normals.push_back({v[0], v[1], v[2]});
    } else if (keyword == "f") {
      read_face(line);
    } else if (keyword == "l" || keyword == "p") {
      leave_out("points and lines");
    } else if (keyword == "g" || keyword == "o") {
      finish_group();
      name_ = next_token(line);
      for (std::string_view more; !(more = next_token(line)).empty();)
        name_ += " " + std::string(more);
    } else if (keyword == "usemtl") {
      const std::string name = trimmed(line);  // exporters put spaces into names
      use_material(material_ids_.contains(name) ? name : std::string(next_token(line)));
    } else if (keyword == "mtllib") {
      read_libraries(line);
    }
  }

  ObjContents finish() {
    finish_group();
    if (out_.meshes.empty()) fail_import(ErrorCode::kInvalid, "expected at least one face", file_);
    const MaterialId grey(static_cast<uint32_t>(materials_.size()));
    for (Mesh& mesh : out_.meshes)
      if (mesh.material == kGrey) mesh.material = grey;
    convert_materials(materials_, folder_, out_);
    out_.materials.emplace_back().name = "grey";
    return std::move(out_);
  }

 private:
  [[noreturn]] void fail(const std::string& message, ErrorCode code = ErrorCode::kInvalid) const {
    fail_import(code, message, file_ + ":" + std::to_string(line_number_));
  }

  // Six numbers are a place and its colour, four a place and a weight, which does not count.
  void read_position(std::string_view line) {
    size_t count = 0;
    const std::array<float, 6> v = numbers<6>(line, 3, &count);
    if (count == 6) {
      Rgb& color = lists_.colors[lists_.positions.size()];
      for (size_t i = 0; i < 3; ++i)
        color[static_cast<int>(i)] = srgb_to_linear(std::clamp(v[3 + i], 0.0f, 1.0f));
    }
    lists_.positions.push_back({v[0], v[1], v[2]});
  }

  void leave_out(const std::string& what) {
    if (unknown_.insert("\n" + what).second)
      out_.warnings.push_back(file_ + ":" + std::to_string(line_number_) + ": " + what +
                              " are left out, here and elsewhere");
  }

  // The first of the line, of which `least` must be there. Those behind must be numbers, too.
  template <size_t N = 3>
  std::array<float, N> numbers(std::string_view line, size_t least, size_t* found = nullptr) const {
    std::array<float, N> out{};
    size_t count = 0;
    for (std::string_view token; !(token = next_token(line)).empty(); ++count) {
      float value = 0;
      if (!parse(token, value) || !std::isfinite(value))
        fail("expected a number, got \"" + std::string(token.substr(0, 40)) + "\"");
      if (count < out.size()) out[count] = value;
    }
    if (count < least)
      fail("expected " + std::to_string(least) + " numbers, got " + std::to_string(count));
    if (found) *found = count;
    return out;
  }

  void read_face(std::string_view line) {
    std::vector<Corner> corners;
    for (std::string_view token; !(token = next_token(line)).empty();)
      corners.push_back(corner(token));
    if (corners.empty()) fail("expected at least 3 corners, got 0");
    if (corners.size() < 3) return leave_out("faces of fewer than 3 corners");
    if (corners.size() > kMaxPolygonCorners) {
      fail("expected at most " + std::to_string(kMaxPolygonCorners) + " corners, got " +
           std::to_string(corners.size()));
    }
    std::vector<Vec3> positions;
    for (const Corner& c : corners)
      positions.push_back(lists_.positions[static_cast<size_t>(c.position)]);
    auto it = group_.find(material_.value);
    if (it == group_.end())
      it = group_.emplace(material_.value, MeshBuilder(lists_, name_, material_)).first;
    for (const auto& [a, b, c] : cut_polygon(positions)) {
      it->second.add_triangle(corners[a], corners[b], corners[c]);
      if (++triangle_count_ > limits_.max_triangles) {
        fail_import(ErrorCode::kTooLarge,
                    "expected at most " + std::to_string(limits_.max_triangles) + " triangles",
                    file_);
      }
    }
  }

  // "v", "v/vt", "v//vn" or "v/vt/vn"; from 1, or from -1 backward.
  Corner corner(std::string_view token) const {
    Corner out;
    const struct {
      int64_t& place;
      size_t count;
      const char* name;
    } parts[] = {{out.position, lists_.positions.size(), "position"},
                 {out.uv, lists_.uvs.size(), "texture coordinate"},
                 {out.normal, lists_.normals.size(), "normal"}};
    std::string_view rest = token;
    for (size_t i = 0; i < 3; ++i) {
      const size_t end = std::min(rest.find('/'), rest.size());
      const std::string_view part = rest.substr(0, end);
      const bool may_be_empty = i == 1 && end < rest.size();  // v//vn
      if (!part.empty() || !may_be_empty)
        parts[i].place = index(part, static_cast<int64_t>(parts[i].count), parts[i].name, token);
      if (end == rest.size()) return out;
      rest.remove_prefix(end + 1);
    }
    fail("expected a corner like 1/2/3, got \"" + std::string(token.substr(0, 40)) + "\"");
  }

  int64_t index(std::string_view part, int64_t count, const char* name,
                std::string_view token) const {
    int64_t value = 0;
    if (!parse(part, value))
      fail("expected a corner like 1/2/3, got \"" + std::string(token.substr(0, 40)) + "\"");
    if (value == 0 || value > count || value < -count) {
      fail("expected the index of one of the " + std::to_string(count) + " " + name +
           "s so far, got " + std::to_string(value));
    }
    return value > 0 ? value - 1 : value + count;
  }

  void use_material(const std::string& name) {
    const auto it = material_ids_.find(name);
    material_ = it == material_ids_.end() ? kGrey : MaterialId(static_cast<uint32_t>(it->second));
    if (it == material_ids_.end() && unknown_.insert(name).second)
      out_.warnings.push_back(file_ + ": there is no material \"" + name + "\": drawn grey");
  }

  // One file whose name may have spaces, or else several.
  void read_libraries(std::string_view line) {
    std::string names(line);
    std::replace(names.begin(), names.end(), '\\', '/');
    line = names;
    const std::string whole = trimmed(line);
    const auto read_once = [&](const std::string& name) {
      if (libraries_.insert(name).second) read_library(name);
    };
    if (find_within(folder_, folder_, whole).ok()) return read_once(whole);
    for (std::string_view name; !(name = next_token(line)).empty();) read_once(std::string(name));
  }

  // One that is missing is a warning.
  void read_library(const std::string& name) {
    const Result<std::filesystem::path> path = find_within(folder_, folder_, name);
    const Result<Bytes> text =
        path.ok() ? read_file(path.value(), kMaxMtlBytes) : Result<Bytes>(path.error());
    if (!text.ok()) {
      out_.warnings.push_back(name + ": " + text.error().message + "; its materials are grey");
      return;
    }
    std::istringstream in(std::string(text.value().begin(), text.value().end()));
    std::string told, errors;
    tinyobj::LoadMtl(&material_ids_, &materials_, &in, &told, &errors);
    std::istringstream lines(told + errors);
    for (std::string line; std::getline(lines, line);)
      if (!line.empty()) out_.warnings.push_back(name + ": " + line);
  }

  void finish_group() {
    for (auto& [material, builder] : group_) out_.meshes.push_back(builder.finish());
    group_.clear();
  }

  const std::string file_;
  const std::filesystem::path folder_;
  const SceneLimits& limits_;
  ObjContents out_;
  Lists lists_;
  std::string name_;  // of the group
  MaterialId material_ = kGrey;
  std::map<uint32_t, MeshBuilder> group_;  // by material, in its order
  std::vector<tinyobj::material_t> materials_;
  std::map<std::string, int> material_ids_;
  std::set<std::string, std::less<>> libraries_, unknown_;
  size_t triangle_count_ = 0;
  int64_t line_number_ = 0;
};

}  // namespace

ObjContents read_obj(const std::filesystem::path& path, const SceneLimits& limits,
                     const LoadWatch& watch) {
  const Result<Bytes> bytes = read_file(path, kMaxObjBytes);
  if (!bytes.ok()) throw ImportFailure{bytes.error()};
  std::string_view text(reinterpret_cast<const char*>(bytes.value().data()), bytes.value().size());
  const auto size = static_cast<double>(text.size());
  constexpr int kLinesBetween = 4096;
  ObjReader reader(path, limits);
  std::string joined;
  for (int64_t line = 0; !text.empty(); ++line) {
    if (line % kLinesBetween == 0) told_read(watch, 1 - static_cast<double>(text.size()) / size);
    // CR alone ends a line, too; one that ends with a backslash goes on in the next.
    const size_t end = std::min(text.find_first_of("\r\n"), text.size());
    std::string_view part = text.substr(0, end);
    const size_t mark = text.substr(end).starts_with("\r\n") ? 2 : 1;
    text.remove_prefix(std::min(end + mark, text.size()));
    const bool goes_on = part.ends_with('\\') && !text.empty();
    if (goes_on) part.remove_suffix(1);
    if (goes_on || !joined.empty()) joined.append(part).append(" ");
    if (goes_on) {
      reader.count_line();
      continue;
    }
    reader.read_line(joined.empty() ? part : std::string_view(joined));
    joined.clear();
  }
  return reader.finish();
}

}  // namespace qray
