// Animations: the scene at a time, and cameras that move in it.
#include <gtest/gtest.h>

#include "core/scene/motion.h"
#include "tests/core/import/gltf_text.h"

namespace qray {
namespace {

using nlohmann::json;
using test::expect_near;
using test::gltf_triangle;
using test::GltfText;
using test::load_gltf;

LoadedScene at(const test::SceneFolder& folder, const GltfText& text, double seconds) {
  auto loaded = load_scene(folder.write("a.gltf", text.gltf()), {{}, false, {}, seconds});
  EXPECT_TRUE(loaded.ok()) << loaded.error().text();
  return std::move(loaded).value();
}

TEST(GltfMotion, ANodeMovesWhatIsBelowIt) {
  const test::SceneFolder folder;
  GltfText text = gltf_triangle();
  text.json["nodes"].push_back({{"children", {0}}, {"translation", {0, 0, 9}}});
  text.json["scenes"][0]["nodes"] = {1};
  text.animate(1, "translation", {0, 2}, {0, 0, 0, 4, 0, 2}, "VEC3");
  text.animate(0, "scale", {0, 1}, {1, 1, 1, 3, 3, 3}, "VEC3");
  const LoadedScene rest = load_gltf(folder, text);
  EXPECT_TRUE(rest.warnings.empty());
  EXPECT_EQ(rest.scene.motion_seconds, 2);
  EXPECT_TRUE(rest.scene.moves_surfaces);
  expect_near(rest.scene.meshes.at(0).positions.at(1), {1, 0, 9});
  const LoadedScene later = at(folder, text, 1.5);
  expect_near(later.scene.meshes.at(0).positions.at(0), {3, 0, 1.5f});
  expect_near(later.scene.meshes.at(0).positions.at(1), {6, 0, 1.5f});
  EXPECT_FALSE(later.hash.geometry == rest.hash.geometry);
  expect_near(at(folder, text, 99).scene.meshes.at(0).positions.at(0), {4, 0, 2});
}

TEST(GltfMotion, ACameraThatMovesLeavesSurfacesAlone) {
  const test::SceneFolder folder;
  GltfText text = gltf_triangle();
  text.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 1}}}}};
  text.json["nodes"].push_back({{"name", "eye"}, {"camera", 0}, {"translation", {0, 0, 5}}});
  text.json["scenes"][0]["nodes"] = {0, 1};
  text.animate(1, "translation", {1, 3}, {0, 0, 5, 2, 0, 5}, "VEC3");
  const Scene scene = load_gltf(folder, text).scene;
  EXPECT_EQ(scene.motion_seconds, 3);
  EXPECT_FALSE(scene.moves_surfaces);
  ASSERT_TRUE(scene.camera_path);
  ASSERT_TRUE(scene.find_camera("eye")->path);
  EXPECT_EQ(scene.camera_path->at(0), scene.camera) << "its first key is where it rests";
  expect_near(scene.camera_path->at(2).position, {1, 0, 5});
  expect_near(scene.camera_path->at(2).target,
              scene.camera_path->at(2).position +
                  Vec3{0, 0, -1} * length(scene.camera_path->at(2).position));
}

TEST(GltfMotion, MorphsAndSkinsFollow) {
  const test::SceneFolder folder;
  GltfText text = gltf_triangle();
  text.primitive()["targets"] = {
      {{"POSITION", text.add_floats({0, 0, 2, 0, 0, 0, 0, 0, 0}, "VEC3")}},
      {{"POSITION", text.add_floats({0, 4, 0, 0, 0, 0, 0, 0, 0}, "VEC3")}}};
  text.animate(0, "weights", {0, 1}, {0, 0, 1, .5f}, "SCALAR");
  EXPECT_TRUE(load_gltf(folder, text).scene.moves_surfaces);
  expect_near(load_gltf(folder, text).scene.meshes.at(0).positions.at(0), {0, 0, 0});
  expect_near(at(folder, text, .5).scene.meshes.at(0).positions.at(0), {0, 1, 1});

  text = gltf_triangle();
  ByteWriter joints;
  for (int i = 0; i < 12; ++i) joints.u8(0);
  json& attributes = text.primitive()["attributes"];
  attributes["JOINTS_0"] = text.add_accessor(text.add_view(joints.data()), 5121, "VEC4", 3);
  attributes["WEIGHTS_0"] = text.add_floats({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
  text.json["skins"] = {{{"joints", {1}}}};
  text.json["nodes"][0]["skin"] = 0;
  text.json["nodes"].push_back({{"name", "joint"}});
  text.json["scenes"][0]["nodes"] = {0, 1};
  text.animate(1, "rotation", {0, 1}, {0, 0, 0, 1, 0, 0, .70710678f, .70710678f}, "VEC4");
  EXPECT_TRUE(load_gltf(folder, text).scene.moves_surfaces);
  expect_near(at(folder, text, 1).scene.meshes.at(0).positions.at(1), {0, 1, 0});
}

TEST(GltfMotion, LightsMove) {
  const test::SceneFolder folder;
  GltfText text = gltf_triangle();
  text.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
  text.json["nodes"].push_back({{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  text.json["scenes"][0]["nodes"] = {0, 1};
  text.animate(1, "translation", {0, 1}, {0, 0, 1, 0, 0, 3}, "VEC3", "STEP");
  EXPECT_TRUE(load_gltf(folder, text).scene.moves_surfaces);
  expect_near(at(folder, text, .9).scene.lights.at(0).position, {0, 0, 1});
  expect_near(at(folder, text, 1).scene.lights.at(0).position, {0, 0, 3});
}

// What is wrong with an animation, or not known, is no reason to refuse the scene at rest.
TEST(GltfMotion, FaultsAreWarnings) {
  const test::SceneFolder folder;
  const auto said = [&](const GltfText& text) {
    const LoadedScene loaded = load_gltf(folder, text);
    EXPECT_EQ(loaded.scene.motion_seconds, 0);
    return loaded.warnings.empty() ? "" : loaded.warnings.front();
  };
  GltfText text = gltf_triangle();
  text.animate(0, "translation", {1, 1}, {0, 0, 0, 1, 1, 1}, "VEC3");
  EXPECT_EQ(said(text), "a.gltf:/accessors/1: expected rising seconds from 0; nothing moves");
  text = gltf_triangle();
  text.animate(0, "translation", {0, 1, 2}, {0, 0, 0, 1, 1, 1}, "VEC3");
  EXPECT_EQ(said(text),
            "a.gltf:/accessors/2/count: expected 3, for so many keys, got 2; nothing moves");
  text = gltf_triangle();
  text.animate(0, "translation", {0, 1}, {0, 0, 0, 1, 1, 1}, "VEC3", "BEZIER");
  EXPECT_EQ(said(text),
            "a.gltf:/animations/0/samplers/0/interpolation: expected LINEAR, STEP or CUBICSPLINE, "
            "got \"BEZIER\"; nothing moves");
  text = gltf_triangle();
  text.animate(0, "pointer", {0, 1}, {0, 0, 0, 1, 1, 1}, "VEC3");
  EXPECT_EQ(said(text), "a.gltf:/animations/0: what moves \"pointer\" is left out");
}

}  // namespace
}  // namespace qray
