// Meshes that Draco or meshoptimizer has packed are the meshes that were packed.
#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include "tests/core/import/gltf_text.h"

namespace qray {
namespace {

using nlohmann::json;
using test::gltf_triangle;
using test::GltfText;
using test::load_gltf;

// Two triangles of a square with uvs, as Draco packs them.
GltfText draco_square() {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(2);
  const int positions =
      builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const int uvs = builder.AddAttribute(draco::GeometryAttribute::TEX_COORD, 2, draco::DT_FLOAT32);
  const float corner[4][3] = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}};
  const float uv[4][2] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
  const int faces[2][3] = {{0, 1, 2}, {0, 2, 3}};
  for (uint32_t f = 0; f < 2; ++f) {
    const int* v = faces[f];
    builder.SetAttributeValuesForFace(positions, draco::FaceIndex(f), corner[v[0]], corner[v[1]],
                                      corner[v[2]]);
    builder.SetAttributeValuesForFace(uvs, draco::FaceIndex(f), uv[v[0]], uv[v[1]], uv[v[2]]);
  }
  const std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(draco::Encoder().EncodeMeshToBuffer(*mesh, &buffer).ok());
  GltfText text = gltf_triangle();
  const int view = text.add_view({reinterpret_cast<const uint8_t*>(buffer.data()), buffer.size()});
  text.json["accessors"] = {{{"componentType", 5126}, {"type", "VEC3"}, {"count", 4}},
                            {{"componentType", 5126}, {"type", "VEC2"}, {"count", 4}},
                            {{"componentType", 5123}, {"type", "SCALAR"}, {"count", 6}}};
  text.primitive()["attributes"] = {{"POSITION", 0}, {"TEXCOORD_0", 1}};
  text.primitive()["indices"] = 2;
  text.primitive()["extensions"]["KHR_draco_mesh_compression"] = {
      {"bufferView", view},
      {"attributes",
       {{"POSITION", mesh->attribute(positions)->unique_id()},
        {"TEXCOORD_0", mesh->attribute(uvs)->unique_id()}}}};
  text.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  return text;
}

TEST(GltfPacked, DracosTrianglesAndTheirVertices) {
  const test::SceneFolder folder;
  const LoadedScene loaded = load_gltf(folder, draco_square());
  EXPECT_TRUE(loaded.warnings.empty());
  const Mesh& mesh = loaded.scene.meshes.at(0);
  ASSERT_EQ(mesh.triangles.size(), 2u);
  ASSERT_EQ(mesh.uvs.size(), mesh.positions.size());
  float area = 0;
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(test::front(mesh, i), (Vec3{0, 0, 1}));
    const auto& t = mesh.triangles[i];
    area += 0.5f * length(cross(mesh.positions[t[1]] - mesh.positions[t[0]],
                                mesh.positions[t[2]] - mesh.positions[t[0]]));
  }
  EXPECT_NEAR(area, 4, 1e-4f);
  for (size_t v = 0; v < mesh.positions.size(); ++v) {  // uvs went with their vertices
    EXPECT_NEAR(mesh.uvs[v].x, mesh.positions[v].x / 2, 1e-3f);
    EXPECT_NEAR(mesh.uvs[v].y, mesh.positions[v].y / 2, 1e-3f);
  }
}

TEST(GltfPacked, DracoFaultsNameTheirPlace) {
  const test::SceneFolder folder;
  const std::string at = "a.gltf:/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression";
  GltfText text = draco_square();
  const auto extension = [&]() -> json& {
    return text.primitive()["extensions"]["KHR_draco_mesh_compression"];
  };
  extension()["attributes"]["POSITION"] = 77;
  EXPECT_EQ(folder.failure("a.gltf", text.gltf()),
            at + "/attributes/POSITION: there is no such attribute in Draco's bytes");
  extension()["attributes"] = {{"NORMAL", 0}};
  EXPECT_EQ(folder.failure("a.gltf", text.gltf()),
            at + "/attributes/NORMAL: expected an attribute that the primitive has too");
  extension()["bufferView"] = 9;
  EXPECT_EQ(folder.failure("a.gltf", text.gltf()),
            at + "/bufferView: expected an integer, 0..1, got 9");
  text = draco_square();
  text.json["bufferViews"][1]["byteLength"] = 20;
  EXPECT_EQ(folder.failure("a.gltf", text.gltf()).find(at + ": Draco's bytes are damaged"), 0u);
}

// The triangle's positions and indices, packed by meshoptimizer, in a buffer without bytes.
GltfText meshopt_triangle() {
  GltfText text = gltf_triangle();
  const float positions[3][3] = {{0, 0, 0}, {3, 0, 0}, {0, 4, 0}};
  Bytes packed(meshopt_encodeVertexBufferBound(3, 12));
  packed.resize(meshopt_encodeVertexBuffer(packed.data(), packed.size(), positions, 3, 12));
  const unsigned indices[3] = {0, 1, 2};
  Bytes packed_indices(meshopt_encodeIndexBufferBound(3, 3));
  packed_indices.resize(
      meshopt_encodeIndexBuffer(packed_indices.data(), packed_indices.size(), indices, 3));
  const auto add = [&](const Bytes& bytes, size_t count, size_t stride, const char* mode) {
    const int view = text.add_view(bytes);
    json& v = text.json["bufferViews"][static_cast<size_t>(view)];
    v["extensions"]["EXT_meshopt_compression"] = {{"buffer", 0},
                                                  {"byteOffset", v["byteOffset"]},
                                                  {"byteLength", bytes.size()},
                                                  {"byteStride", stride},
                                                  {"count", count},
                                                  {"mode", mode}};
    v["byteOffset"] = 0;
    v["byteLength"] = count * stride;
    return view;
  };
  text.primitive()["attributes"]["POSITION"] =
      text.add_accessor(add(packed, 3, 12, "ATTRIBUTES"), 5126, "VEC3", 3);
  text.primitive()["indices"] =
      text.add_accessor(add(packed_indices, 3, 2, "TRIANGLES"), 5123, "SCALAR", 3);
  text.json["extensionsRequired"] = {"EXT_meshopt_compression", "KHR_mesh_quantization"};
  return text;
}

TEST(GltfPacked, MeshoptimizersViews) {
  const test::SceneFolder folder;
  const LoadedScene loaded = load_gltf(folder, meshopt_triangle());
  EXPECT_TRUE(loaded.warnings.empty());
  const Mesh& mesh = loaded.scene.meshes.at(0);
  ASSERT_EQ(mesh.triangles.size(), 1u);
  EXPECT_EQ(mesh.positions, (std::vector<Vec3>{{0, 0, 0}, {3, 0, 0}, {0, 4, 0}}));
}

TEST(GltfPacked, AFallbackBufferNeedsNoBytes) {
  const test::SceneFolder folder;
  const GltfText text = meshopt_triangle();
  json out = json::parse(text.gltf());
  out["buffers"].push_back(
      {{"byteLength", 1000}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}});
  for (size_t v = 1; v < 3; ++v) out["bufferViews"][v]["buffer"] = 1;
  const auto loaded = folder.load("a.gltf", out.dump());
  ASSERT_TRUE(loaded.ok()) << loaded.error().text();
  EXPECT_EQ(loaded.value().scene.meshes.at(0).positions.at(1), (Vec3{3, 0, 0}));
}

TEST(GltfPacked, OctahedralNormals) {
  const test::SceneFolder folder;
  GltfText text = gltf_triangle();
  const float normals[3][4] = {{0, 0, 1, 0}, {0.6f, 0, 0.8f, 0}, {0, -0.6f, 0.8f, 0}};
  int8_t filtered[3][4];
  meshopt_encodeFilterOct(filtered, 3, 4, 8, &normals[0][0]);
  Bytes packed(meshopt_encodeVertexBufferBound(3, 4));
  packed.resize(meshopt_encodeVertexBuffer(packed.data(), packed.size(), filtered, 3, 4));
  const int view = text.add_view(packed);
  json& v = text.json["bufferViews"][static_cast<size_t>(view)];
  v["extensions"]["EXT_meshopt_compression"] = {{"buffer", 0},
                                                {"byteOffset", v["byteOffset"]},
                                                {"byteLength", packed.size()},
                                                {"byteStride", 4},
                                                {"count", 3},
                                                {"mode", "ATTRIBUTES"},
                                                {"filter", "OCTAHEDRAL"}};
  v["byteStride"] = 4;
  const int accessor = text.add_accessor(view, 5120, "VEC3", 3);
  text.json["accessors"][static_cast<size_t>(accessor)]["normalized"] = true;
  text.primitive()["attributes"]["NORMAL"] = accessor;
  const LoadedScene loaded = load_gltf(folder, text);
  const std::vector<Vec3>& read = loaded.scene.meshes.at(0).normals;
  ASSERT_EQ(read.size(), 3u);
  for (size_t i = 0; i < 3; ++i)
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(read[i][c], normals[i][c], 0.02f) << i;
}

TEST(GltfPacked, MeshoptFaultsNameTheirPlace) {
  const test::SceneFolder folder;
  const std::string at = "a.gltf:/bufferViews/1/extensions/EXT_meshopt_compression";
  const auto failure = [&](const char* key, const json& value) {
    GltfText text = meshopt_triangle();
    text.json["bufferViews"][1]["extensions"]["EXT_meshopt_compression"][key] = value;
    return folder.failure("a.gltf", text.gltf());
  };
  EXPECT_EQ(failure("mode", "WORDS"),
            at + "/mode: expected ATTRIBUTES, TRIANGLES or INDICES, got \"WORDS\"");
  EXPECT_EQ(failure("filter", "SEPIA"),
            at + "/filter: expected NONE, OCTAHEDRAL, QUATERNION or EXPONENTIAL, got \"SEPIA\"");
  EXPECT_EQ(failure("byteStride", 6), at + "/byteStride: expected a multiple of 4, got 6");
  EXPECT_EQ(failure("byteLength", 3), at + ": the packed bytes are damaged");
  EXPECT_EQ(failure("byteOffset", 100000).find(at + ": expected byteOffset and byteLength within"),
            0u);
  EXPECT_EQ(failure("count", 1 << 30).find(at + "/count: more than "), 0u);
}

}  // namespace
}  // namespace qray
