// Skins and morph targets at rest.
#include <gtest/gtest.h>

#include "tests/core/import/gltf_text.h"

namespace qray {
namespace {

using nlohmann::json;
using test::expect_near;
using test::gltf_triangle;
using test::GltfText;
using test::load_gltf;

// Vertex 0 follows joint 0, vertex 1 joint 1, vertex 2 both by half.
GltfText skinned() {
  GltfText text = gltf_triangle();
  ByteWriter joints;
  for (const uint8_t j : {0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0}) joints.u8(j);
  json& attributes = text.primitive()["attributes"];
  attributes["JOINTS_0"] = text.add_accessor(text.add_view(joints.data()), 5121, "VEC4", 3);
  attributes["WEIGHTS_0"] = text.add_floats({1, 0, 0, 0, 1, 0, 0, 0, .5f, .5f, 0, 0}, "VEC4");
  attributes["NORMAL"] = text.add_floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
  text.json["skins"] = {{{"joints", {1, 2}}}};
  text.json["nodes"][0]["skin"] = 0;
  text.json["nodes"][0]["translation"] = {100, 0, 0};  // does not count
  text.json["nodes"].push_back({{"translation", {0, 0, 5}}, {"children", {2}}});
  text.json["nodes"].push_back({{"rotation", {1, 0, 0, 0}}, {"translation", {0, 2, 0}}});
  text.json["scenes"][0]["nodes"] = {0, 1};
  return text;
}

TEST(GltfPose, VerticesFollowTheirJoints) {
  const test::SceneFolder folder;
  const LoadedScene loaded = load_gltf(folder, skinned());
  EXPECT_TRUE(loaded.warnings.empty());
  const Mesh& mesh = loaded.scene.meshes.at(0);
  ASSERT_EQ(mesh.positions.size(), 3u);
  expect_near(mesh.positions[0], {0, 0, 5});
  expect_near(mesh.positions[1], {1, 2, 5});  // turned half about x, then moved by both
  expect_near(mesh.positions[2], (Vec3{0, 1, 5} + Vec3{0, 1, 5}) * 0.5f);
  expect_near(mesh.normals[0], {0, 0, 1});
  expect_near(mesh.normals[1], {0, 0, -1});
}

TEST(GltfPose, InverseMatricesComeFirst) {
  const test::SceneFolder folder;
  GltfText text = skinned();
  std::vector<float> matrices;
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 16; ++i) matrices.push_back(i % 5 == 0 ? 1 : i == 14 ? -5 : 0);
  ByteWriter out;
  for (const float v : matrices) out.f32(v);
  text.json["skins"][0]["inverseBindMatrices"] =
      text.add_accessor(text.add_view(out.data()), 5126, "MAT4", 2);
  const LoadedScene loaded = load_gltf(folder, text);
  expect_near(loaded.scene.meshes.at(0).positions.at(0), {0, 0, 0});
  text.json["accessors"].back()["count"] = 1;
  EXPECT_EQ(folder.failure("a.gltf", text.gltf()),
            "a.gltf:/accessors/4/count: expected at least 2, as many as joints, got 1");
}

TEST(GltfPose, SkinFaults) {
  const test::SceneFolder folder;
  GltfText text = skinned();
  text.json["scenes"][0]["nodes"] = {0};
  EXPECT_EQ(load_gltf(folder, text).warnings,
            std::vector<std::string>{
                "a.gltf:/skins/0/joints/0: the joint is not in the scene: drawn without skin"});
  text = skinned();
  text.json["skins"][0]["joints"] = {1};
  EXPECT_EQ(folder.failure("a.gltf", text.gltf()), "a.gltf:/accessors/1: expected joints below 1");
  text = skinned();
  text.primitive()["attributes"].erase("WEIGHTS_0");
  EXPECT_EQ(
      folder.failure("a.gltf", text.gltf()),
      "a.gltf:/meshes/0/primitives/0/attributes: expected JOINTS_0 and WEIGHTS_0 for its skin");
}

TEST(GltfPose, MorphTargetsByTheWeightsOfTheNodeElseOfTheMesh) {
  const test::SceneFolder folder;
  GltfText text = gltf_triangle();
  text.primitive()["targets"] = {
      {{"POSITION", text.add_floats({0, 0, 2, 0, 0, 0, 0, 0, 0}, "VEC3")}},
      {{"POSITION", text.add_floats({0, 0, 0, 0, 4, 0, 0, 0, 0}, "VEC3")}}};
  json& mesh = text.json["meshes"][0];
  EXPECT_EQ(load_gltf(folder, text).scene.meshes.at(0).positions.at(0), (Vec3{0, 0, 0}));
  mesh["weights"] = {0.5, 0.25};
  const LoadedScene by_mesh = load_gltf(folder, text);
  EXPECT_TRUE(by_mesh.warnings.empty());
  EXPECT_EQ(by_mesh.scene.meshes.at(0).positions,
            (std::vector<Vec3>{{0, 0, 1}, {1, 1, 0}, {0, 1, 0}}));
  text.json["nodes"].push_back({{"mesh", 0}, {"weights", {1, 0}}});
  text.json["scenes"][0]["nodes"] = {0, 1};
  const LoadedScene both = load_gltf(folder, text);
  ASSERT_EQ(both.scene.meshes.size(), 2u);
  EXPECT_EQ(both.scene.meshes[0].positions.at(0), (Vec3{0, 0, 1}));
  EXPECT_EQ(both.scene.meshes[1].positions.at(0), (Vec3{0, 0, 2}));
}

}  // namespace
}  // namespace qray
