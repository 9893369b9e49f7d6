// "motion" of JSON scenes: the scene at a time, and cameras that are carried along.
#include "core/import/json_motion.h"

#include <gtest/gtest.h>

#include "tests/core/import/scene_text.h"

namespace qray {
namespace {

const std::string kCamera =
    R"("camera": {"position": [0, 1, 3], "target": [0, 1, 0], "vertical_fov_deg": 40})";
const std::string kQuad =
    R"("meshes": [{"material": "a",
                   "quad": {"origin": [0,0,0], "edge1": [0,0,1], "edge2": [1,0,0]}}])";

std::string document(const std::string& camera, const std::string& meshes) {
  return "{" + camera + R"(,"materials": [{"name": "a", "type": "diffuse"}],)" + meshes + "}";
}

constexpr const char* kMoving = R"("meshes": [
    {"name": "slides", "material": "a", "transform": {"translate": [1, 0, 0]},
     "quad": {"origin": [0,0,0], "edge1": [0,0,1], "edge2": [1,0,0]},
     "motion": {"seconds": [1, 3], "translate": [[0,0,0], [0,4,0]], "scale": [1, 3]}},
    {"name": "turns", "material": "a", "sphere": {"center": [2,0,0], "radius": 1, "exact": true},
     "motion": {"seconds": [0, 4], "center": [1,0,0],
                "rotate": {"axis": [0,0,2], "deg": [0, 720]}}},
    {"name": "stands", "material": "a",
     "quad": {"origin": [0,0,0], "edge1": [0,0,1], "edge2": [1,0,0]}}],
  "instances": [{"mesh": "stands", "transform": {"translate": [0,0,5]},
                 "motion": {"seconds": [0, 1], "rotate": {"axis": [0,1,0], "deg": [0, 90]}}}],
  "lights": [{"type": "spot", "position": [0,2,0], "direction": [0,-1,0], "intensity": 1,
              "outer_deg": 40,
              "motion": {"seconds": [0, 1], "translate": [[0,0,0], [3,0,0]],
                         "rotate": {"axis": [0,0,1], "deg": [0, 90]}}}])";

Scene moving_scene(const test::SceneFolder& folder, std::optional<double> seconds) {
  auto loaded =
      load_scene(folder.write("scene.json", document(kCamera, kMoving)), {{}, false, {}, seconds});
  EXPECT_TRUE(loaded.ok()) << loaded.error().text();
  return std::move(loaded).value().scene;
}

void expect_close(Vec3 a, Vec3 b) {
  EXPECT_LT(length(a - b), 1e-5f) << a.x << " " << a.y << " " << a.z;
}

TEST(JsonMotion, WhatMovesIsThereAtItsTime) {
  const test::SceneFolder folder;
  const Scene rest = moving_scene(folder, std::nullopt);
  EXPECT_EQ(rest.motion_seconds, 4);
  EXPECT_TRUE(rest.moves_surfaces);
  EXPECT_EQ(rest.meshes[0].positions[0], (Vec3{1, 0, 0}));
  const Scene middle = moving_scene(folder, 2);
  expect_close(middle.meshes[0].positions[0], {2, 2, 0});
  // Two turns in four seconds: after .25 s an eighth of a turn, 45 degrees, about x = 1.
  const float half = std::sqrt(0.5f);
  expect_close(moving_scene(folder, 0.25).meshes[1].sphere->center, {1 + half, half, 0});
  expect_close(middle.meshes[1].sphere->center, {2, 0, 0});
  const Scene later = moving_scene(folder, 9);
  expect_close(later.instances[0].to_world.point({0, 0, 0}), {5, 0, 0});
  expect_close(later.lights[0].position, {1, 0, 0});
  expect_close(later.lights[0].direction, {1, 0, 0});
}

TEST(JsonMotion, ACameraIsCarriedAlong) {
  const test::SceneFolder folder;
  const std::string moving = kCamera.substr(0, kCamera.size() - 1) + R"(, "mirrored": true,
     "aperture_radius": 0.1, "motion": {"seconds": [0, 2], "center": [0, 1, 0],
                                        "rotate": {"axis": [0,1,0], "deg": [0, 90]}}})";
  const auto loaded = folder.load("scene.json", document(moving, kQuad));
  ASSERT_TRUE(loaded.ok()) << loaded.error().text();
  const Scene& scene = loaded.value().scene;
  EXPECT_FALSE(scene.moves_surfaces);
  ASSERT_TRUE(scene.camera_path);
  const Camera at_first = scene.camera_path->at(0), at_last = scene.camera_path->at(2);
  expect_close(at_first.position, scene.camera.position);
  expect_close(normalize(at_first.target - at_first.position), {0, 0, -1});
  expect_close(at_last.position, {3, 1, 0});
  expect_close(normalize(at_last.target - at_last.position), {-1, 0, 0});
  expect_close(at_last.up, {0, 1, 0});
  EXPECT_TRUE(at_last.mirrored);
  EXPECT_EQ(at_last.focus_distance, 3) << "the target's distance";
}

TEST(JsonMotion, MotionSaysWhatItExpects) {
  const test::SceneFolder folder;
  const auto failure = [&](const std::string& motion) {
    return folder.failure("scene.json",
                          document(kCamera, R"("meshes": [{"material": "a", "motion": {)" + motion +
                                                R"(}, "box": {"min": [0,0,0], "max": [1,1,1]}}])"));
  };
  EXPECT_EQ(failure(R"("translate": [[0,0,0]])"),
            "scene.json:/meshes/0/motion: \"seconds\" is missing");
  EXPECT_EQ(failure(R"("seconds": [0])"),
            "scene.json:/meshes/0/motion: expected \"translate\", \"rotate\" or \"scale\"");
  EXPECT_EQ(
      failure(R"("seconds": [0, 2, 2], "scale": [1, 1, 1])"),
      "scene.json:/meshes/0/motion/seconds/2: expected a time after the one before it, got 2");
  EXPECT_EQ(failure(R"("seconds": [0, 2], "scale": [1])").substr(0, 79),
            "scene.json:/meshes/0/motion/scale: expected 2 values, one for each of \"seconds\"");
  EXPECT_EQ(failure(R"("seconds": [0], "rotate": {"axis": [0,0,0], "deg": [1]})").substr(0, 40),
            "scene.json:/meshes/0/motion/rotate/axis:");
}

}  // namespace
}  // namespace qray
