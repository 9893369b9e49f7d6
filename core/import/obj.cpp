#include "core/import/obj.h"

#include <tiny_obj_loader.h>

#include <algorithm>
#include <map>
#include <sstream>
#include <unordered_map>

#include "core/base/file.h"
#include "core/import/import_failure.h"
#include "core/import/mtl.h"
#include "core/import/obj_check.h"
#include "core/import/scene_folder.h"
#include "core/math/hash.h"

namespace qray {
namespace {

constexpr uint64_t kMaxObjBytes = uint64_t{1} << 30;
constexpr uint64_t kMaxMtlBytes = uint64_t{16} << 20;

// Of the time that reading takes, about.
constexpr double kChecked = 0.3, kParsed = 0.7;

// The text as a stream that tells how much of it was taken.
class WatchedText : public std::streambuf {
 public:
  WatchedText(std::string& text, const LoadWatch& watch) : text_(text), watch_(watch) {}

 protected:
  int_type underflow() override {
    constexpr size_t kChunk = 1 << 20;
    if (at_ == text_.size()) return traits_type::eof();
    told_read(watch_, kChecked + (kParsed - kChecked) * static_cast<double>(at_) /
                                     static_cast<double>(text_.size()));
    const size_t end = std::min(at_ + kChunk, text_.size());
    setg(text_.data() + at_, text_.data() + at_, text_.data() + end);
    at_ = end;
    return traits_type::to_int_type(*gptr());
  }

 private:
  std::string& text_;
  const LoadWatch& watch_;
  size_t at_ = 0;
};

// Finds the material libraries beside the OBJ; one that is missing is a warning.
class MtlReader : public tinyobj::MaterialReader {
 public:
  MtlReader(std::filesystem::path folder, std::vector<std::string>& warnings)
      : folder_(std::move(folder)), warnings_(warnings) {}

  bool operator()(const std::string& name, std::vector<tinyobj::material_t>* materials,
                  std::map<std::string, int>* ids, std::string* warn, std::string* err) override {
    const Result<std::filesystem::path> path = find_within(folder_, folder_, name);
    const Result<Bytes> text =
        path.ok() ? read_file(path.value(), kMaxMtlBytes) : Result<Bytes>(path.error());
    if (!text.ok()) {
      warnings_.push_back(name + ": " + text.error().message + "; its materials are grey");
      return true;
    }
    std::istringstream in(std::string(text.value().begin(), text.value().end()));
    tinyobj::LoadMtl(ids, materials, &in, warn, err);
    return true;
  }

 private:
  std::filesystem::path folder_;
  std::vector<std::string>& warnings_;
};

void add_lines(const std::string& text, const std::string& file,
               std::vector<std::string>& warnings) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (!line.empty()) warnings.push_back(file + ": " + line);
}

using Corner = tinyobj::index_t;
struct CornerHash {
  size_t operator()(const Corner& c) const {
    const auto u = [](int v) { return static_cast<uint64_t>(static_cast<uint32_t>(v)); };
    return hash_combine(u(c.vertex_index) << 32 | u(c.normal_index), u(c.texcoord_index));
  }
};
struct CornerEqual {
  bool operator()(const Corner& a, const Corner& b) const {
    return a.vertex_index == b.vertex_index && a.normal_index == b.normal_index &&
           a.texcoord_index == b.texcoord_index;
  }
};

// One mesh of the corners of one group and material, equal corners shared.
class MeshBuilder {
 public:
  MeshBuilder(const tinyobj::attrib_t& attrib, const std::string& name, MaterialId material)
      : attrib_(attrib) {
    mesh_.name = name;
    mesh_.material = material;
  }

  void add_triangle(const Corner* corners) {
    mesh_.triangles.push_back({vertex(corners[0]), vertex(corners[1]), vertex(corners[2])});
  }

  Mesh finish() {
    if (!has_normals_) mesh_.normals.clear();
    if (!has_uvs_) mesh_.uvs.clear();
    return std::move(mesh_);
  }

 private:
  uint32_t vertex(const Corner& c) {
    const auto [it, is_new] =
        vertices_.try_emplace(c, static_cast<uint32_t>(mesh_.positions.size()));
    if (!is_new) return it->second;
    const auto vec3 = [](const std::vector<float>& list, int i) {
      const float* v = &list[3 * static_cast<size_t>(i)];
      return Vec3{v[0], v[1], v[2]};
    };
    mesh_.positions.push_back(vec3(attrib_.vertices, c.vertex_index));
    Vec3 normal;
    if (c.normal_index >= 0) normal = vec3(attrib_.normals, c.normal_index);
    const float norm = length(normal);
    // A mesh with a normal missing or without length is drawn flat.
    has_normals_ = has_normals_ && norm > 0 && std::isfinite(norm);
    mesh_.normals.push_back(normal / norm);
    Vec2 uv;
    if (c.texcoord_index >= 0) {
      const float* t = &attrib_.texcoords[2 * static_cast<size_t>(c.texcoord_index)];
      uv = {t[0], t[1]};
    }
    has_uvs_ = has_uvs_ || c.texcoord_index >= 0;
    mesh_.uvs.push_back(uv);
    return it->second;
  }

  const tinyobj::attrib_t& attrib_;
  Mesh mesh_;
  bool has_normals_ = true, has_uvs_ = false;
  std::unordered_map<Corner, uint32_t, CornerHash, CornerEqual> vertices_;
};

void add_meshes(const tinyobj::attrib_t& attrib, const tinyobj::shape_t& shape,
                uint32_t grey_material, std::vector<Mesh>& meshes) {
  std::map<uint32_t, MeshBuilder> builders;  // by material, in its order
  const std::vector<Corner>& corners = shape.mesh.indices;
  for (size_t i = 0; 3 * i + 2 < corners.size(); ++i) {
    const int id = shape.mesh.material_ids[i];
    const uint32_t material = id < 0 ? grey_material : static_cast<uint32_t>(id);
    auto it = builders.find(material);
    if (it == builders.end())
      it = builders.emplace(material, MeshBuilder(attrib, shape.name, MaterialId(material))).first;
    it->second.add_triangle(&corners[3 * i]);
  }
  for (auto& [material, builder] : builders) meshes.push_back(builder.finish());
}

}  // namespace

ObjContents read_obj(const std::filesystem::path& path, const SceneLimits& limits,
                     const LoadWatch& watch) {
  const std::string file = path.filename();
  const Result<Bytes> bytes = read_file(path, kMaxObjBytes);
  if (!bytes.ok()) throw ImportFailure{bytes.error()};
  std::string text(bytes.value().begin(), bytes.value().end());
  check_obj_lines(text, file, [&](double fraction) { told_read(watch, fraction * kChecked); });

  tinyobj::attrib_t attrib;
  std::vector<tinyobj::shape_t> shapes;
  std::vector<tinyobj::material_t> materials;
  std::string warn, err;
  ObjContents out;
  const std::filesystem::path folder = scene_folder(path);
  MtlReader mtl(folder, out.warnings);
  WatchedText buffer(text, watch);
  std::istream in(&buffer);
  if (!tinyobj::LoadObj(&attrib, &shapes, &materials, &warn, &err, &in, &mtl)) {
    std::replace(err.begin(), err.end(), '\n', ' ');
    fail_import(ErrorCode::kInvalid, err.empty() ? "not an OBJ file" : err, file);
  }
  told_read(watch, kParsed);  // a stream hides what its buffer throws
  add_lines(warn, file, out.warnings);

  const auto grey_material = static_cast<uint32_t>(materials.size());
  size_t triangles = 0;
  for (const tinyobj::shape_t& shape : shapes) {
    triangles += shape.mesh.material_ids.size();
    if (triangles > limits.max_triangles) {
      fail_import(ErrorCode::kTooLarge,
                  "expected at most " + std::to_string(limits.max_triangles) + " triangles", file);
    }
    add_meshes(attrib, shape, grey_material, out.meshes);
  }
  if (out.meshes.empty()) fail_import(ErrorCode::kInvalid, "expected at least one face", file);
  convert_materials(materials, folder, out);
  out.materials.emplace_back().name = "grey";
  return out;
}

}  // namespace qray
