// Primitives of every mode as triangles, and what comes with their vertices.
#include <gtest/gtest.h>

#include "tests/core/import/gltf_text.h"

namespace qray {
namespace {

using test::gltf_triangle;
using test::GltfText;
using test::load_gltf;

// Corners of a zigzag (a strip's) or of a ring about the first (a fan's), all facing +z.
const std::vector<float> kZigzag = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0};
const std::vector<float> kRing = {0, 0, 0, 2, 0, 0, 2, 1, 0, 1, 2, 0, 0, 2, 0};

TEST(GltfMesh, StripsAndFansFaceOneWay) {
  const test::SceneFolder folder;
  for (const int mode : {5, 6}) {
    for (const bool indexed : {false, true}) {
      GltfText text = gltf_triangle();
      text.primitive()["attributes"]["POSITION"] =
          text.add_floats(mode == 5 ? kZigzag : kRing, "VEC3");
      if (indexed) text.primitive()["indices"] = text.add_indices({0, 1, 2, 3, 4});
      text.primitive()["mode"] = mode;
      const LoadedScene loaded = load_gltf(folder, text);
      const Mesh& mesh = loaded.scene.meshes.at(0);
      ASSERT_EQ(mesh.triangles.size(), 3u);
      for (size_t i = 0; i < 3; ++i) EXPECT_EQ(test::front(mesh, i), (Vec3{0, 0, 1})) << mode;
      EXPECT_EQ(mesh.positions.size(), 5u);
    }
  }
}

TEST(GltfMesh, IndicesOfEveryWidth) {
  const test::SceneFolder folder;
  for (const int type : {5121, 5123, 5125}) {
    GltfText text = gltf_triangle();
    ByteWriter out;
    for (const uint8_t i : {2, 0, 1, 0, 1}) {  // two are left over
      if (type == 5121) out.u8(i);
      if (type == 5123) out.u16(i);
      if (type == 5125) out.u32(i);
    }
    text.primitive()["indices"] = text.add_accessor(text.add_view(out.data()), type, "SCALAR", 5);
    const LoadedScene loaded = load_gltf(folder, text);
    const Mesh& mesh = loaded.scene.meshes.at(0);
    ASSERT_EQ(mesh.triangles.size(), 1u);
    EXPECT_EQ(mesh.triangles[0], (std::array<uint32_t, 3>{2, 0, 1})) << type;
  }
}

TEST(GltfMesh, IndexFaultsNameTheirPlace) {
  const test::SceneFolder folder;
  GltfText text = gltf_triangle();
  text.primitive()["indices"] = text.add_indices({0, 1, 3});
  EXPECT_EQ(folder.failure("a.gltf", text.gltf()),
            "a.gltf:/meshes/0/primitives/0/indices: expected indices below 3, got 3 at 2");
  text.primitive()["indices"] = text.add_floats({0, 1, 2}, "SCALAR");
  EXPECT_EQ(folder.failure("a.gltf", text.gltf()),
            "a.gltf:/accessors/2/componentType: expected 5121, 5123 or 5125, got 5126");
  text.primitive()["indices"] = text.add_floats({0, 1, 2}, "VEC3");
  EXPECT_EQ(folder.failure("a.gltf", text.gltf()),
            "a.gltf:/accessors/3/type: expected SCALAR, got \"VEC3\"");
  text.json["accessors"][1].erase("bufferView");
  text.primitive()["indices"] = 1;
  EXPECT_EQ(folder.failure("a.gltf", text.gltf()),
            "a.gltf:/meshes/0/primitives/0/indices: expected an accessor with a bufferView");
}

TEST(GltfMesh, VerticesThatAPrimitiveDoesNotUseAreNotKept) {
  const test::SceneFolder folder;
  GltfText text = gltf_triangle();
  std::vector<float> positions(3 * 1000);
  for (size_t i = 0; i < 1000; ++i) {
    positions[3 * i] = static_cast<float>(i);
    positions[3 * i + 1] = static_cast<float>(i * i % 1000);
  }
  std::vector<float> uvs(2 * 1000, 0.25f);
  uvs[2 * 700] = 0.75f;
  text.primitive()["attributes"]["POSITION"] = text.add_floats(positions, "VEC3");
  text.primitive()["attributes"]["TEXCOORD_0"] = text.add_floats(uvs, "VEC2");
  text.primitive()["indices"] = text.add_indices({900, 5, 700});
  const LoadedScene loaded = load_gltf(folder, text);
  const Mesh& mesh = loaded.scene.meshes.at(0);
  ASSERT_EQ(mesh.positions.size(), 3u);
  EXPECT_EQ(mesh.positions[mesh.triangles[0][0]], (Vec3{900, 0, 0}));
  EXPECT_EQ(mesh.positions[mesh.triangles[0][1]], (Vec3{5, 25, 0}));
  EXPECT_EQ(mesh.uvs[mesh.triangles[0][2]], (Vec2{0.75f, 0.75f}));
}

TEST(GltfMesh, PointsAndLinesAreLeftOutWithAWarning) {
  const test::SceneFolder folder;
  GltfText text = gltf_triangle();
  auto& primitives = text.json["meshes"][0]["primitives"];
  for (const int mode : {0, 1, 2, 3}) {
    primitives.push_back(primitives[0]);
    primitives.back()["mode"] = mode;
  }
  const LoadedScene loaded = load_gltf(folder, text);
  EXPECT_EQ(loaded.scene.triangle_count(), 1u);
  EXPECT_EQ(loaded.warnings,
            (std::vector<std::string>{"a.gltf:/meshes/0/primitives/1: points are left out",
                                      "a.gltf:/meshes/0/primitives/2: lines are left out "
                                      "(and in 2 more places)"}));
}

TEST(GltfMesh, NormalsAreUnitOrNoneAtAll) {
  const test::SceneFolder folder;
  EXPECT_TRUE(load_gltf(folder, gltf_triangle()).scene.meshes.at(0).normals.empty());
  GltfText text = gltf_triangle();
  text.primitive()["attributes"]["NORMAL"] = text.add_floats({0, 0, 2, 0, 3, 4, 0, 0, 1}, "VEC3");
  const Mesh mesh = load_gltf(folder, text).scene.meshes.at(0);
  EXPECT_EQ(mesh.normals[0], (Vec3{0, 0, 1}));
  EXPECT_FLOAT_EQ(mesh.normals[1].y, 0.6f);
  text.primitive()["attributes"]["NORMAL"] = text.add_floats({0, 0, 2, 0, 0, 0, 0, 0, 1}, "VEC3");
  const LoadedScene flat = load_gltf(folder, text);
  EXPECT_TRUE(flat.scene.meshes.at(0).normals.empty());
  EXPECT_EQ(flat.warnings, std::vector<std::string>{
                               "a.gltf:/accessors/2: has normals without a direction: drawn flat"});
}

TEST(GltfMesh, AttributesHaveOneValueAVertex) {
  const test::SceneFolder folder;
  for (const char* name : {"NORMAL", "COLOR_0"}) {
    GltfText text = gltf_triangle();
    text.primitive()["attributes"][name] = text.add_floats({0, 0, 1, 0, 0, 1}, "VEC3");
    EXPECT_EQ(folder.failure("a.gltf", text.gltf()),
              "a.gltf:/accessors/1/count: expected 3, as of the positions, got 2");
  }
}

TEST(GltfMesh, TexcoordsTurnUpwardAndFollowTheMaterial) {
  const test::SceneFolder folder;
  GltfText text = gltf_triangle();
  auto& attributes = text.primitive()["attributes"];
  attributes["TEXCOORD_0"] = text.add_floats({0, 0, 1, 0, 0.25f, 1}, "VEC2");
  attributes["TEXCOORD_1"] = text.add_floats({0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 0.5f}, "VEC2");
  EXPECT_EQ(load_gltf(folder, text).scene.meshes.at(0).uvs,
            (std::vector<Vec2>{{0, 1}, {1, 1}, {0.25f, 0}}));

  folder.write("p.png", "not read here");
  text.json["images"] = {{{"uri", "p.png"}}};
  text.json["textures"] = {{{"source", 0}}};
  text.json["materials"][0] = {
      {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}, {"texCoord", 1}}}}}};
  const LoadedScene second = load_gltf(folder, text);
  EXPECT_EQ(second.scene.meshes.at(0).uvs[0], (Vec2{0.5f, 0.5f}));
  EXPECT_TRUE(second.warnings.empty());

  text.json["materials"][0]["normalTexture"] = {{"index", 0}};
  const LoadedScene mixed = load_gltf(folder, text);  // the normal map's are the first
  EXPECT_EQ(mixed.scene.meshes.at(0).uvs[0], (Vec2{0, 1}));
  EXPECT_EQ(mixed.scene.meshes.at(0).second_uvs[0], (Vec2{0.5f, 0.5f}));
  const Material& m = mixed.scene.materials.at(0);
  EXPECT_TRUE(mixed.scene.textures[m.reflectance.texture.value].second_uvs);
  EXPECT_FALSE(mixed.scene.textures[m.normal_map.value].second_uvs);
  EXPECT_TRUE(mixed.warnings.empty());

  text.json["materials"][0]["emissiveTexture"] = {{"index", 0}, {"texCoord", 2}};
  EXPECT_EQ(
      load_gltf(folder, text).warnings,
      std::vector<std::string>{
          "a.gltf:/materials/0/emissiveTexture: is drawn with TEXCOORD_0, not TEXCOORD_2: the "
          "material's textures ask for more than two sets of uvs"});
}

TEST(GltfMesh, ColorsOfVertices) {
  const test::SceneFolder folder;
  GltfText text = gltf_triangle();
  text.primitive()["attributes"]["COLOR_0"] =
      text.add_floats({1, 0.5f, 0, 1, 0, 0, 1, 0.25f, 0, 0, 2, 1}, "VEC4");
  const std::string clamped = "a.gltf:/accessors/1: colours outside 0..1 are drawn as the nearest";
  const LoadedScene opaque = load_gltf(folder, text);
  EXPECT_EQ(opaque.scene.meshes.at(0).colors,
            (std::vector<Rgb>{{1, 0.5f, 0}, {0, 0, 1}, {0, 0, 1}}));
  EXPECT_EQ(opaque.warnings, std::vector<std::string>{clamped});
  text.json["materials"][0]["alphaMode"] = "BLEND";
  EXPECT_EQ(load_gltf(folder, text).warnings,
            (std::vector<std::string>{clamped,
                                      "a.gltf:/accessors/1: the alpha of vertices is left out"}));
}

}  // namespace
}  // namespace qray
