// Nodes, instances, cameras and lights.
#include <gtest/gtest.h>

#include <numbers>

#include "tests/core/import/gltf_text.h"
#include "tests/support/near.h"

namespace qray {
namespace {

using nlohmann::json;
using test::expect_near;
using test::gltf_triangle;
using test::GltfText;
using test::load_gltf;

TEST(GltfScene, NodesScaleThenTurnThenMoveAndFollowThoseAbove) {
  const test::SceneFolder folder;
  const float h = std::sqrt(0.5f);
  GltfText text = gltf_triangle();
  // A quarter turn about z below a move and a scale by 2.
  text.json["nodes"] = {
      {{"children", {1}}, {"translation", {0, 0, 5}}, {"scale", {2, 2, 2}}},
      {{"mesh", 0}, {"rotation", {0, 0, h, h}}, {"translation", {1, 0, 0}}, {"scale", {3, 1, 1}}}};
  const Mesh mesh = load_gltf(folder, text).scene.meshes.at(0);
  expect_near(mesh.positions[0], {2, 0, 5});
  expect_near(mesh.positions[1], {2, 6, 5});  // x: scaled by 3, then along y
  expect_near(mesh.positions[2], {0, 0, 5});  // y: along -x
  expect_near(test::front(mesh, 0), {0, 0, 1});

  GltfText matrix = gltf_triangle();  // the inner node's map, by columns
  matrix.json["nodes"] = {
      text.json["nodes"][0],
      {{"mesh", 0}, {"matrix", {0, 3, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 1, 0, 0, 1}}}};
  const Mesh same = load_gltf(folder, matrix).scene.meshes.at(0);
  for (size_t i = 0; i < 3; ++i) expect_near(same.positions[i], mesh.positions[i]);
}

TEST(GltfScene, MirroringKeepsFrontsInFront) {
  const test::SceneFolder folder;
  GltfText text = gltf_triangle();
  text.primitive()["attributes"]["NORMAL"] = text.add_floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
  text.json["nodes"][0]["scale"] = {-1, 1, 1};
  const Mesh mesh = load_gltf(folder, text).scene.meshes.at(0);
  EXPECT_EQ(mesh.positions[1], (Vec3{-1, 0, 0}));
  EXPECT_EQ(test::front(mesh, 0), (Vec3{0, 0, 1}));
  EXPECT_EQ(mesh.normals[0], (Vec3{0, 0, 1}));
}

TEST(GltfScene, MeshesUsedMoreThanOnceAreInstances) {
  const test::SceneFolder folder;
  GltfText text = gltf_triangle();
  text.json["nodes"] = {{{"children", {1, 2, 3}}},
                        {{"mesh", 0}},
                        {{"mesh", 0}, {"translation", {4, 0, 0}}},
                        {{"mesh", 0}, {"scale", {0, 1, 1}}}};
  const LoadedScene loaded = load_gltf(folder, text);
  ASSERT_EQ(loaded.scene.instances.size(), 2u);
  EXPECT_EQ(loaded.scene.triangle_count(), 1u);
  EXPECT_EQ(loaded.scene.placed_triangle_count(), 2u);
  expect_near(loaded.scene.instances[1].to_world.point({0, 0, 0}), {4, 0, 0});
  EXPECT_EQ(loaded.warnings,
            std::vector<std::string>{"a.gltf:/nodes/3: a mesh flattened to nothing is left out"});
  text.json["nodes"][2]["translation"] = {2e6, 0, 0};
  EXPECT_TRUE(folder.failure("a.gltf", text.gltf())
                  .starts_with("a.gltf:/nodes/2/transform: expected a place within 1e6 m"));
}

TEST(GltfScene, GpuInstancesAreBelowTheirNode) {
  const test::SceneFolder folder;
  const float h = std::sqrt(0.5f);
  GltfText text = gltf_triangle();
  json& attributes = text.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
  attributes["TRANSLATION"] = text.add_floats({0, 0, 0, 1, 2, 3}, "VEC3");
  attributes["ROTATION"] = text.add_floats({0, 0, 0, 1, 0, 0, h, h}, "VEC4");
  attributes["SCALE"] = text.add_floats({1, 1, 1, 3, 1, 1}, "VEC3");
  text.json["nodes"][0]["translation"] = {10, 0, 0};
  text.json["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
  const LoadedScene loaded = load_gltf(folder, text);
  ASSERT_EQ(loaded.scene.instances.size(), 2u);
  expect_near(loaded.scene.instances[0].to_world.point({1, 0, 0}), {11, 0, 0});
  expect_near(loaded.scene.instances[1].to_world.point({1, 0, 0}), {11, 5, 3});
  EXPECT_TRUE(loaded.warnings.empty());

  const std::string at = "a.gltf:/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes";
  attributes["SCALE"] = text.add_floats({1, 1, 1}, "VEC3");
  EXPECT_EQ(folder.failure("a.gltf", text.gltf()),
            at + "/SCALE: expected 2 elements, as the others have");
  attributes["SCALE"] = 99;
  EXPECT_EQ(folder.failure("a.gltf", text.gltf()),
            at + "/SCALE: expected an integer, 0..4, got 99");
  attributes = {{"_ID", 0}};
  EXPECT_EQ(folder.failure("a.gltf", text.gltf()),
            at + ": expected TRANSLATION, ROTATION or SCALE");
  attributes = {{"TRANSLATION", 0}};
  text.json["accessors"][0].erase("bufferView");
  text.json["accessors"][0]["count"] = 1'000'001;
  EXPECT_EQ(folder.failure("a.gltf", text.gltf()),
            "a.gltf:/accessors/0/count: expected at most 1000000, got 1000001");
}

TEST(GltfScene, OnlyTheDefaultSceneIsDrawnAndWithoutOneAllIs) {
  const test::SceneFolder folder;
  GltfText text = gltf_triangle();
  text.json["nodes"] = {{{"mesh", 0}}, {{"mesh", 0}, {"translation", {0, 7, 0}}}};
  text.json["scenes"] = {{{"nodes", {0}}}, {{"nodes", {1}}}};
  text.json["scene"] = 1;
  const LoadedScene loaded = load_gltf(folder, text);
  EXPECT_EQ(loaded.scene.meshes.at(0).positions[0], (Vec3{0, 7, 0}));
  EXPECT_EQ(loaded.warnings,
            std::vector<std::string>{"a.gltf:/scenes: only the default scene is drawn"});
  text.json.erase("scenes");
  text.json.erase("scene");
  EXPECT_EQ(load_gltf(folder, text).scene.instances.size(), 2u);
}

TEST(GltfScene, CyclesAreAnErrorHoweverLong) {
  const test::SceneFolder folder;
  GltfText text = gltf_triangle();
  json nodes = json::array();
  for (int i = 0; i < 20'000; ++i) nodes.push_back({{"children", {i + 1}}});
  nodes.push_back({{"mesh", 0}});
  text.json["nodes"] = nodes;
  EXPECT_EQ(load_gltf(folder, text).scene.triangle_count(), 1u);
  text.json["nodes"].back() = {{"children", {10'000}}};
  EXPECT_EQ(folder.failure("a.gltf", text.gltf()),
            "a.gltf:/nodes/10000: expected a node below one other at most, no cycles");
}

TEST(GltfScene, CamerasLookAlongTheirNodesMinusZ) {
  const test::SceneFolder folder;
  GltfText text = gltf_triangle();
  text.json["cameras"] = {
      {{"type", "perspective"},
       {"perspective", {{"yfov", std::numbers::pi / 3}, {"znear", 0.1}, {"aspectRatio", 4}}}},
      {{"type", "orthographic"}, {"orthographic", {{"xmag", 3}, {"ymag", -1.5}}}}};
  text.json["nodes"] = {{{"mesh", 0}, {"children", {1, 2}}},
                        {{"camera", 0}, {"translation", {1, 2, 3}}, {"scale", {2, 2, -2}}},
                        {{"camera", 0}}};
  const LoadedScene loaded = load_gltf(folder, text);
  const Scene& scene = loaded.scene;
  EXPECT_EQ(scene.camera.position, (Vec3{1, 2, 3}));
  expect_near(normalize(scene.camera.target - scene.camera.position), {0, 0, 1});
  EXPECT_EQ(scene.camera.up, (Vec3{0, 1, 0}));
  EXPECT_TRUE(scene.camera.mirrored);
  EXPECT_FLOAT_EQ(scene.camera.vertical_fov_deg, 60);
  EXPECT_EQ(scene.width, 1024);
  EXPECT_EQ(scene.height, 256);
  EXPECT_EQ(loaded.warnings, std::vector<std::string>{});
  ASSERT_EQ(scene.cameras.size(), 2u);
  EXPECT_EQ(scene.cameras[0].name, "camera-1");
  EXPECT_EQ(scene.cameras[0].camera, scene.camera);
  EXPECT_EQ(scene.cameras[1].camera.position, (Vec3{0, 0, 0}));

  text.json["nodes"][1] = {{"camera", 1}};
  text.json["nodes"][2] = json::object();
  const LoadedScene parallel = load_gltf(folder, text);
  EXPECT_EQ(parallel.scene.camera.projection, Projection::kOrthographic);
  EXPECT_EQ(parallel.scene.camera.height, 3);
  EXPECT_EQ(parallel.scene.width, 724);  // twice as wide as high
  EXPECT_EQ(parallel.scene.height, 362);
  EXPECT_EQ(parallel.warnings, std::vector<std::string>{});

  text.json["cameras"][1]["orthographic"]["ymag"] = 0;
  EXPECT_EQ(folder.failure("a.gltf", text.gltf()),
            "a.gltf:/cameras/1/orthographic/ymag: expected a length over 0, at most 5e5 m, got 0");
}

TEST(GltfScene, LightsShineAlongTheirNodesMinusZ) {
  const test::SceneFolder folder;
  GltfText text = gltf_triangle();
  text.json["extensions"]["KHR_lights_punctual"]["lights"] = json::parse(R"([
    {"type": "point", "color": [1, 0.5, 0], "intensity": 4, "range": 3},
    {"type": "spot", "spot": {"innerConeAngle": 0.25}},
    {"type": "directional", "intensity": 2}])");
  text.json["nodes"][0]["children"] = {1, 2, 3};
  for (const int i : {0, 1, 2}) {
    text.json["nodes"].push_back({{"translation", {0, 0, 5}}, {"rotation", {1, 0, 0, 0}}});
    text.json["nodes"].back()["extensions"]["KHR_lights_punctual"]["light"] = i;
  }
  const LoadedScene loaded = load_gltf(folder, text);
  EXPECT_TRUE(loaded.warnings.empty());
  EXPECT_FALSE(loaded.scene.environment.present());
  const auto& lights = loaded.scene.lights;
  ASSERT_EQ(lights.size(), 3u);
  EXPECT_EQ(lights[0].kind, LightKind::kPoint);
  EXPECT_EQ(lights[0].intensity, (Rgb{4, 2, 0}));
  EXPECT_EQ(lights[0].position, (Vec3{0, 0, 5}));
  EXPECT_EQ(lights[1].kind, LightKind::kSpot);
  expect_near(lights[1].direction, {0, 0, 1});
  EXPECT_FLOAT_EQ(lights[1].inner_rad, 0.25f);
  EXPECT_FLOAT_EQ(lights[1].outer_rad, kPi / 4);
  EXPECT_EQ(lights[2].kind, LightKind::kDirectional);
  EXPECT_EQ(lights[2].intensity, Rgb{2.0f});
}

TEST(GltfScene, LightAndCameraFaultsNameTheirPlace) {
  const test::SceneFolder folder;
  const std::string light = "/extensions/KHR_lights_punctual/lights/0";
  const struct {
    const char* light;
    std::string failure;
  } cases[] = {
      {R"({"type": "area"})", light + "/type: expected point, spot or directional, got \"area\""},
      {R"({"type": "spot"})", light + ": \"spot\" is missing"},
      {R"({"type": "spot", "spot": {"outerConeAngle": 2}})",
       light + "/spot/outerConeAngle: expected 1e-06..1.5708, got 2"},
      {R"({"type": "spot", "spot": {"innerConeAngle": 1}})",
       light + "/spot/innerConeAngle: expected 0..0.785398, got 1"},
      {R"({"type": "point", "intensity": -1})", light + "/intensity: expected 0..1e+12, got -1"},
      {R"({"type": "point", "color": [1, 1]})", light + "/color: expected an array of 3 numbers"},
  };
  for (const auto& c : cases) {
    GltfText text = gltf_triangle();
    text.json["extensions"]["KHR_lights_punctual"]["lights"] = {json::parse(c.light)};
    text.json["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0;
    const std::string failure = folder.failure("a.gltf", text.gltf());
    EXPECT_TRUE(failure.starts_with("a.gltf:" + c.failure)) << failure;
  }
  GltfText text = gltf_triangle();
  text.json["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0;
  EXPECT_EQ(folder.failure("a.gltf", text.gltf()),
            "a.gltf:/nodes/0/extensions/KHR_lights_punctual/light: expected no index, there are no "
            "lights");
  text = gltf_triangle();
  text.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 4}}}}};
  text.json["nodes"][0]["camera"] = 0;
  EXPECT_EQ(folder.failure("a.gltf", text.gltf()),
            "a.gltf:/cameras/0/perspective/yfov: expected 0.0001..3.13845, got 4");
  text.json["cameras"][0]["perspective"]["yfov"] = 1;
  text.json["nodes"][0]["scale"] = {1, 1, 0};
  EXPECT_EQ(folder.failure("a.gltf", text.gltf()),
            "a.gltf:/nodes/0: is flattened by the nodes above it");
}

TEST(GltfScene, WhatIsLeftOutIsAWarning) {
  const test::SceneFolder folder;
  GltfText text = gltf_triangle();
  text.json["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "a"}}};
  text.json["nodes"][0]["extensions"]["KHR_node_visibility"] = {{"visible", false}};
  EXPECT_EQ(load_gltf(folder, text).warnings,
            (std::vector<std::string>{
                "a.gltf:/extensions/KHR_materials_variants: drawn with the materials of no variant",
                "a.gltf:/nodes/0/extensions/KHR_node_visibility: the extension KHR_node_visibility "
                "is left out"}));
  const auto strict = load_scene(folder.path() / "a.gltf", {{}, true, {}});
  EXPECT_FALSE(strict.ok());
}

TEST(GltfScene, ASkyLightsWhatNoLightDoes) {
  const test::SceneFolder folder;
  folder.write("p.png", "not read here");
  const struct {
    const char* material;
    bool sky;
  } cases[] = {
      {R"({})", true},
      {R"({"emissiveFactor": [0, 1, 0]})", false},
      {R"({"emissiveFactor": [0, 1, 0], "emissiveTexture": {"index": 0}})", true},
      {R"({"extensions": {"KHR_materials_unlit": {}}})", true},
  };
  for (const auto& c : cases) {
    GltfText text = gltf_triangle();
    text.json["images"] = {{{"uri", "p.png"}}};
    text.json["textures"] = {{{"source", 0}}};
    text.json["materials"] = {json::parse(c.material)};
    EXPECT_EQ(load_gltf(folder, text).scene.environment.present(), c.sky) << c.material;
  }
}

}  // namespace
}  // namespace qray
