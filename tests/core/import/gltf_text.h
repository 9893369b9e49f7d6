// glTF documents of a few lines, for the importer's tests.
#pragma once

#include <nlohmann/json.hpp>

#include "core/base/byte_io.h"
#include "tests/core/import/scene_text.h"

namespace qray::test {

inline std::string base64(std::span<const uint8_t> bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t bits = 0;
    for (size_t k = 0; k < 3; ++k) bits = bits << 8 | (i + k < bytes.size() ? bytes[i + k] : 0u);
    for (size_t k = 0; k < 4; ++k)
      out += i + k <= bytes.size() ? kDigits[bits >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

// A document whose only buffer is `binary`.
struct GltfText {
  nlohmann::json json;
  Bytes binary;

  int add_view(std::span<const uint8_t> bytes) {
    while (binary.size() % 4 != 0) binary.push_back(0);
    json["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", bytes.size()}});
    binary.insert(binary.end(), bytes.begin(), bytes.end());
    return static_cast<int>(json["bufferViews"].size()) - 1;
  }
  int add_accessor(int view, int component_type, const std::string& type, size_t count) {
    json["accessors"].push_back({{"bufferView", view},
                                 {"componentType", component_type},
                                 {"type", type},
                                 {"count", count}});
    return static_cast<int>(json["accessors"].size()) - 1;
  }
  int add_floats(const std::vector<float>& values, const std::string& type) {
    ByteWriter out;
    for (const float v : values) out.f32(v);
    const size_t components = type == "SCALAR" ? 1 : static_cast<size_t>(type.back() - '0');
    return add_accessor(add_view(out.data()), 5126, type, values.size() / components);
  }
  int add_indices(const std::vector<uint16_t>& values) {
    ByteWriter out;
    for (const uint16_t v : values) out.u16(v);
    return add_accessor(add_view(out.data()), 5123, "SCALAR", values.size());
  }
  // An animation of one channel. `type`: of the values, such as "VEC3".
  void animate(int node, const std::string& path, const std::vector<float>& seconds,
               const std::vector<float>& values, const std::string& type,
               const std::string& interpolation = "LINEAR") {
    const int input = add_floats(seconds, "SCALAR"), output = add_floats(values, type);
    json["animations"].push_back(
        {{"samplers", {{{"input", input}, {"output", output}, {"interpolation", interpolation}}}},
         {"channels", {{{"sampler", 0}, {"target", {{"node", node}, {"path", path}}}}}}});
  }
  nlohmann::json& primitive(size_t mesh = 0) { return json["meshes"][mesh]["primitives"][0]; }

  std::string gltf() const {
    nlohmann::json out = json;
    out["buffers"] = {{{"byteLength", binary.size()},
                       {"uri", "data:application/octet-stream;base64," + base64(binary)}}};
    return out.dump();
  }
  std::string glb() const {
    nlohmann::json out = json;
    out["buffers"] = {{{"byteLength", binary.size()}}};
    std::string text = out.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    Bytes padded = binary;
    padded.resize((padded.size() + 3) / 4 * 4);
    ByteWriter file;
    file.u32(0x46546c67);
    file.u32(2);
    file.u32(static_cast<uint32_t>(28 + text.size() + padded.size()));
    file.u32(static_cast<uint32_t>(text.size()));
    file.u32(0x4e4f534a);
    file.bytes({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
    file.u32(static_cast<uint32_t>(padded.size()));
    file.u32(0x004e4942);
    file.bytes(padded);
    return {file.data().begin(), file.data().end()};
  }
};

// Mesh 0 at node 0 of scene 0: a unit triangle facing +z with material 0, without indices.
inline GltfText gltf_triangle() {
  GltfText text;
  text.json = nlohmann::json::parse(R"({"asset": {"version": "2.0"}, "scene": 0,
    "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], "materials": [{"name": "m"}],
    "meshes": [{"primitives": [{"attributes": {}, "material": 0}]}]})");
  text.primitive()["attributes"]["POSITION"] = text.add_floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3");
  return text;
}

inline void expect_near(Vec3 a, Vec3 b) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], 1e-5f);
}

inline LoadedScene load_gltf(const SceneFolder& folder, const GltfText& text) {
  auto loaded = folder.load("a.gltf", text.gltf());
  EXPECT_TRUE(loaded.ok()) << loaded.error().text();
  return loaded.ok() ? std::move(loaded).value() : LoadedScene{};
}

}  // namespace qray::test
