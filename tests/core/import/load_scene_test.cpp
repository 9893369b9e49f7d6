#include "core/import/load_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "core/import/fit_camera.h"
#include "core/import/primitives.h"
#include "core/import/resolve_scene.h"
#include "tests/core/import/scene_text.h"
#include "tests/support/places.h"

namespace qray {
namespace {

const std::filesystem::path kScenes = test::source_dir() / "scenes";

TEST(LoadScene, IncludedScenesLoadCleanly) {
  for (const char* name : {"ajar-door", "cornell-box", "furnace", "glass-caustic", "lamp-room",
                           "many-lights", "studio", "thesis-room"}) {
    const auto path = resolve_scene_path(name, kScenes);
    ASSERT_TRUE(path.ok()) << path.error().text();
    const auto loaded = load_scene(path.value());
    ASSERT_TRUE(loaded.ok()) << loaded.error().text();
    EXPECT_TRUE(loaded.value().warnings.empty()) << name << ": " << loaded.value().warnings[0];
    EXPECT_EQ(loaded.value().dropped_triangles, 0u) << name;
    EXPECT_TRUE(std::filesystem::exists(path.value().parent_path() / "SOURCE.md")) << name;
  }
}

TEST(LoadScene, ManyLightsHasTwoHundredLampsFacingDown) {
  const auto loaded = load_scene(kScenes / "many-lights" / "scene.json");
  ASSERT_TRUE(loaded.ok()) << loaded.error().text();
  const Scene& s = loaded.value().scene;
  size_t triangles = 0;
  for (const Mesh& mesh : s.meshes) {
    if (!s.materials[mesh.material.value].emits()) continue;
    triangles += mesh.triangles.size();
    for (size_t i = 0; i < mesh.triangles.size(); ++i) EXPECT_LT(test::front(mesh, i).y, -0.999f);
  }
  EXPECT_EQ(triangles, 400u);
}

TEST(LoadScene, ErrorsNameTheFile) {
  const test::SceneFolder folder;
  EXPECT_EQ(folder.failure("a.txt", "x"),
            "a.txt: expected a .json, .xml, .gltf, .glb, .obj or .ply file");
  EXPECT_EQ(folder.failure("a.json", "[\n}").substr(0, 9), "a.json:2:");
  const auto missing = load_scene(folder.path() / "gone.json");
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_NE(missing.error().text().find("gone.json"), std::string::npos);
  EXPECT_FALSE(load_scene(folder.path() / "").ok());
}

TEST(LoadScene, LimitsHoldForEveryFormat) {
  const test::SceneFolder folder;
  const SceneLimits limits{.max_triangles = 1};
  const auto json = folder.write("a.json", R"({"camera": {"position": [0,0,3], "target": [0,0,0],
    "vertical_fov_deg": 40}, "materials": [{"name": "a", "type": "diffuse"}], "meshes": [
    {"material": "a", "box": {"min": [0,0,0], "max": [1,1,1]}}]})");
  const auto obj = folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
  const auto ply = folder.write("a.ply",
                                "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
                                "property float y\nproperty float z\nelement face 1\nproperty list "
                                "uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n"
                                "4 0 1 2 3\n");
  for (const auto& path : {json, obj, ply}) {
    EXPECT_TRUE(load_scene(path).ok()) << path;
    const auto loaded = load_scene(path, {limits, false, {}});
    ASSERT_FALSE(loaded.ok()) << path;
    EXPECT_EQ(loaded.error().code, ErrorCode::kTooLarge) << loaded.error().text();
  }
}

TEST(LoadScene, TellsHowFarReadingIs) {
  test::ScratchFolder folder;
  std::ofstream obj(folder / "grid.obj");
  constexpr int kVertices = 60'000;  // over a MiB of text
  for (int i = 0; i < kVertices; ++i) obj << "v " << i << " " << i % 7 << " " << i % 11 << "\n";
  for (int i = 1; i + 2 <= kVertices; i += 3)
    obj << "f " << i << " " << i + 1 << " " << i + 2 << "\n";
  obj.close();
  for (const auto& path : {folder / "grid.obj", kScenes / "cornell-box" / "scene.json"}) {
    std::vector<double> told;
    const LoadWatch watch = [&](LoadStep step, double fraction) {
      EXPECT_EQ(step, LoadStep::kReading);
      told.push_back(fraction);
      return true;
    };
    ASSERT_TRUE(load_scene(path, {{}, false, watch}).ok());
    EXPECT_GE(told.size(), 5u) << path;
    EXPECT_TRUE(std::is_sorted(told.begin(), told.end())) << path;
    EXPECT_LE(told.back(), 1) << path;
    EXPECT_GE(told.back(), 0.5) << path;
    // Whenever it is told to stop it does.
    for (size_t stop_at = 0; stop_at < told.size(); stop_at += 3) {
      size_t calls = 0;
      const auto stopped =
          load_scene(path, {{}, false, [&](LoadStep, double) { return calls++ < stop_at; }});
      ASSERT_FALSE(stopped.ok()) << path << " at " << stop_at;
      EXPECT_EQ(stopped.error().code, ErrorCode::kCanceled) << path;
    }
  }
}

TEST(LoadScene, ASceneWithoutLightIsAWarning) {
  const test::SceneFolder folder;
  const auto loaded = folder.load("a.json", R"({"camera": {"position": [0,0,3],
    "target": [0,0,0], "vertical_fov_deg": 40}, "materials": [{"name": "a", "type": "diffuse"}],
    "meshes": [{"material": "a", "box": {"min": [0,0,0], "max": [1,1,1]}}]})");
  ASSERT_TRUE(loaded.ok()) << loaded.error().text();
  EXPECT_EQ(loaded.value().warnings, std::vector<std::string>{"a.json: nothing emits light"});
}

// Is every corner of the bounding box in the picture?
bool sees_all(const Scene& scene, const Camera& camera) {
  const Bounds3 box = scene.bounds();
  const Vec3 forward = normalize(camera.target - camera.position);
  const Vec3 right = normalize(cross(forward, camera.up)), up = cross(right, forward);
  const float half = std::tan(camera.vertical_fov_deg * kPi / 360);
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 p{corner & 1 ? box.hi.x : box.lo.x, corner & 2 ? box.hi.y : box.lo.y,
                 corner & 4 ? box.hi.z : box.lo.z};
    const Vec3 d = p - camera.position;
    const float depth = dot(d, forward);
    if (!(depth > 0 && std::abs(dot(d, right)) <= half * depth &&
          std::abs(dot(d, up)) <= half * depth))
      return false;
  }
  return true;
}

TEST(FitCamera, ChoosesByTheKindOfScene) {
  Scene object;
  object.meshes = {make_sphere({10, -3, 4}, 2, 2)};
  EXPECT_TRUE(sees_all(object, fit_camera(object)));

  Scene open_box, room;
  Mesh mesh = make_box({-1, 0, -1}, {1, 2, 1});
  room.meshes = {mesh};
  std::erase_if(mesh.triangles, [&mesh](const auto& t) {
    return mesh.positions[t[0]].z > 0 && mesh.positions[t[1]].z > 0 && mesh.positions[t[2]].z > 0;
  });
  ASSERT_EQ(mesh.triangles.size(), 10u);
  open_box.meshes = {mesh};
  const Camera outside = fit_camera(open_box);
  EXPECT_GT(outside.position.z, 1);
  EXPECT_TRUE(sees_all(open_box, outside));
  const Camera inside = fit_camera(room);
  EXPECT_GT(inside.position.z, 0.5f);
  EXPECT_LT(inside.position.z, 1);
}

// Where fronts are known, a closed box is a thing, and one turned inside out is a room.
TEST(FitCamera, FrontsTellRoomsFromThings) {
  Scene scene;
  scene.meshes = {make_box({-2, 0, -4}, {2, 2, 4})};
  EXPECT_TRUE(sees_all(scene, fit_camera(scene, /*fronts_are_known=*/true)));
  flip_winding(scene.meshes[0]);
  const Camera inside = fit_camera(scene, /*fronts_are_known=*/true);
  EXPECT_LT(std::abs(inside.position.x), 2);
  EXPECT_LT(std::abs(inside.position.z), 4);
  EXPECT_GT(length(inside.target - inside.position), 2);  // along the room, not across
  EXPECT_EQ(inside.target.y, inside.position.y);

  // Two things with a gap between them.
  scene.meshes = {make_box({-2, 0, 0}, {-0.1f, 2, 2}), make_box({0.1f, 0, 0}, {2, 2, 2})};
  EXPECT_TRUE(sees_all(scene, fit_camera(scene, /*fronts_are_known=*/true)));
}

TEST(ResolveScene, FindsNamesFoldersAndFiles) {
  const auto file = kScenes / "cornell-box" / "scene.json";
  for (const std::string& given :
       {std::string("cornell-box"), file.string(), file.parent_path().string()}) {
    const auto path = resolve_scene_path(given, kScenes);
    ASSERT_TRUE(path.ok()) << path.error().text();
    EXPECT_TRUE(std::filesystem::equivalent(path.value(), file)) << given;
  }
  EXPECT_EQ(resolve_scene_path("no-such-scene", kScenes).error().code, ErrorCode::kNotFound);
  EXPECT_FALSE(resolve_scene_path("/no/such/file.json", kScenes).ok());
}

TEST(ResolveScene, NamesFromOutsideAreNeverPaths) {
  for (const char* name : {"", ".", "..", "../scenes/furnace", "furnace/", "Furnace",
                           "furnace.json", "/etc", "furnace\n", "fur nace", "a%2e"}) {
    const auto path = resolve_scene_name(name, kScenes);
    ASSERT_FALSE(path.ok()) << name;
    EXPECT_EQ(path.error().code, ErrorCode::kInvalid) << name;
  }
  EXPECT_FALSE(is_scene_name(std::string(65, 'a')));
  EXPECT_FALSE(is_scene_name(std::string_view("a\0b", 3)));
  EXPECT_TRUE(resolve_scene_name("furnace", kScenes).ok());
  EXPECT_EQ(resolve_scene_name("nothing", kScenes).error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace qray
