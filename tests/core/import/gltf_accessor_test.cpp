// Component types and layouts of accessors, seen as the mesh they make.
#include <gtest/gtest.h>

#include "tests/core/import/gltf_text.h"

namespace qray {
namespace {

using nlohmann::json;
using test::gltf_triangle;
using test::GltfText;
using test::load_gltf;

std::vector<Rgb> colors_of(const test::SceneFolder& folder, const GltfText& text) {
  return load_gltf(folder, text).scene.meshes.at(0).colors;
}

TEST(GltfAccessor, NormalizedIntegersAreShares) {
  const test::SceneFolder folder;
  const Rgb expected[] = {{0, 0.2f, 1}, {1, 1, 1}, {0, 0, 0}};
  const std::array<uint8_t, 9> parts = {0, 51, 255, 255, 255, 255, 0, 0, 0};
  for (const int type : {5121, 5123}) {
    GltfText text = gltf_triangle();
    ByteWriter out;
    for (size_t i = 0; i < 9; ++i) {
      if (type == 5121)
        out.u8(parts[i]);
      else
        out.u16(static_cast<uint16_t>(257 * parts[i]));
      if (i % 3 == 2 && type == 5121) out.u8(77);  // elements start at multiples of four
      if (i % 3 == 2 && type == 5123) out.u16(777);
    }
    const int view = text.add_view(out.data());
    text.json["bufferViews"][static_cast<size_t>(view)]["byteStride"] = type == 5121 ? 4 : 8;
    const int accessor = text.add_accessor(view, type, "VEC3", 3);
    text.json["accessors"][static_cast<size_t>(accessor)]["normalized"] = true;
    text.primitive()["attributes"]["COLOR_0"] = accessor;
    const std::vector<Rgb> colors = colors_of(folder, text);
    ASSERT_EQ(colors.size(), 3u);
    for (size_t i = 0; i < 3; ++i)
      for (int c = 0; c < 3; ++c) EXPECT_FLOAT_EQ(colors[i][c], expected[i][c]) << type;
  }
}

TEST(GltfAccessor, QuantizedPositionsAreNumbers) {
  const test::SceneFolder folder;
  for (const bool normalized : {false, true}) {
    for (const bool wide : {false, true}) {
      GltfText text = gltf_triangle();
      text.json["extensionsRequired"] = {"KHR_mesh_quantization"};
      ByteWriter out;
      for (const int v : {0, 0, 0, 127, 0, 0, 0, -128, 0}) {
        if (wide)
          out.u16(static_cast<uint16_t>(v == 127 ? 32767 : v * 256));
        else
          out.u8(static_cast<uint8_t>(v));
      }
      const int accessor =
          text.add_accessor(text.add_view(out.data()), wide ? 5122 : 5120, "VEC3", 3);
      text.json["accessors"][static_cast<size_t>(accessor)]["normalized"] = normalized;
      text.primitive()["attributes"]["POSITION"] = accessor;
      const LoadedScene loaded = load_gltf(folder, text);
      const Mesh& mesh = loaded.scene.meshes.at(0);
      const float one = normalized ? 1 : wide ? 32767 : 127;
      const float least = normalized ? -1 : wide ? -32768 : -128;
      EXPECT_EQ(mesh.positions[1], (Vec3{one, 0, 0}));
      EXPECT_EQ(mesh.positions[2], (Vec3{0, least, 0}));
    }
  }
}

TEST(GltfAccessor, InterleavedIsReadAsApart) {
  const test::SceneFolder folder;
  GltfText apart = gltf_triangle(), together = gltf_triangle();
  const std::vector<float> p = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const std::vector<float> n = {0, 0, 1, 0, 0.6f, 0.8f, 0.6f, 0, 0.8f};
  apart.primitive()["attributes"]["NORMAL"] = apart.add_floats(n, "VEC3");
  ByteWriter out;
  for (size_t i = 0; i < 3; ++i) {
    for (size_t c = 0; c < 3; ++c) out.f32(p[3 * i + c]);
    for (size_t c = 0; c < 3; ++c) out.f32(n[3 * i + c]);
  }
  const int view = together.add_view(out.data());
  together.json["bufferViews"][1]["byteStride"] = 24;
  for (const char* name : {"POSITION", "NORMAL"}) {
    const int accessor = together.add_accessor(view, 5126, "VEC3", 3);
    together.json["accessors"][static_cast<size_t>(accessor)]["byteOffset"] =
        name[0] == 'P' ? 0 : 12;
    together.primitive()["attributes"][name] = accessor;
  }
  EXPECT_EQ(load_gltf(folder, apart).hash, load_gltf(folder, together).hash);
}

TEST(GltfAccessor, SparseReplacesElementsOfAViewOrOfZeros) {
  const test::SceneFolder folder;
  for (const bool zeros : {false, true}) {
    GltfText text = gltf_triangle();
    ByteWriter indices, values;
    for (const uint8_t i : {0, 2}) indices.u8(i);
    for (const float v : {5, 0, 0, 0, 7, 0}) values.f32(v);
    text.json["accessors"][0]["sparse"] = {
        {"count", 2},
        {"indices", {{"bufferView", text.add_view(indices.data())}, {"componentType", 5121}}},
        {"values", {{"bufferView", text.add_view(values.data())}}}};
    if (zeros) text.json["accessors"][0].erase("bufferView");
    const Mesh mesh = load_gltf(folder, text).scene.meshes.at(0);
    EXPECT_EQ(mesh.positions[0], (Vec3{5, 0, 0}));
    EXPECT_EQ(mesh.positions[1], (Vec3{zeros ? 0.0f : 1.0f, 0, 0}));
    EXPECT_EQ(mesh.positions[2], (Vec3{0, 7, 0}));
  }
}

TEST(GltfAccessor, SparseFaultsNameTheirPlace) {
  const test::SceneFolder folder;
  const struct {
    std::vector<uint8_t> indices;
    json patch;
    const char* failure;
  } cases[] = {
      {{0, 3}, {}, "/indices: expected ascending indices below 3, got 3 at 1"},
      {{2, 2}, {}, "/indices: expected ascending indices below 3, got 2 at 1"},
      {{0, 1}, {{"count", 4}}, "/count: expected an integer, 1..3, got 4"},
      {{0, 1}, {{"count", 3}}, "/indices: expected 3 bytes in bufferView 1, got 2"},
      {{0, 1}, {{"values", {{"byteOffset", 4}}}}, "/values: expected 28 bytes in bufferView 2"},
      {{0, 1},
       {{"indices", {{"componentType", 5126}}}},
       "/indices/componentType: expected one of 5121, 5123, 5125, got 5126"},
      {{0, 1}, {{"values", nullptr}}, ": \"values\" is missing"},
  };
  for (const auto& c : cases) {
    GltfText text = gltf_triangle();
    json& sparse = text.json["accessors"][0]["sparse"];
    sparse["count"] = 2;
    sparse["indices"] = {{"bufferView", text.add_view(c.indices)}, {"componentType", 5121}};
    ByteWriter values;
    for (int i = 0; i < 6; ++i) values.f32(1);
    sparse["values"] = {{"bufferView", text.add_view(values.data())}};
    sparse.merge_patch(c.patch.is_null() ? json::object() : c.patch);
    const std::string failure = folder.failure("a.gltf", text.gltf());
    EXPECT_TRUE(failure.starts_with(std::string("a.gltf:/accessors/0/sparse") + c.failure))
        << failure;
  }
}

TEST(GltfAccessor, NumbersThatAreNoneAreAnError) {
  const test::SceneFolder folder;
  for (const float wrong : {NAN, INFINITY, 1e30f}) {
    GltfText text = gltf_triangle();
    text.primitive()["attributes"]["POSITION"] =
        text.add_floats({0, 0, 0, 1, wrong, 0, 0, 1, 0}, "VEC3");
    EXPECT_TRUE(folder.failure("a.gltf", text.gltf())
                    .starts_with("a.gltf:/meshes/0/primitives/0/positions/1: expected numbers "
                                 "within 1e6 m"));
  }
}

}  // namespace
}  // namespace qray
