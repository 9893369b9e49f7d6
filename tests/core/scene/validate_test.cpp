#include "core/scene/validate.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

namespace qray {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

Scene good_scene() {
  Scene scene;
  scene.materials.resize(2);
  scene.textures.resize(1);
  scene.instances.push_back({MeshId(1), {}, {}});
  scene.lights.resize(3);
  scene.lights[1].kind = LightKind::kSpot;
  scene.lights[2].kind = LightKind::kDirectional;
  for (int i = 0; i < 2; ++i) {
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.normals = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
    mesh.uvs = {{0, 0}, {1, 0}, {0, 1}};
    mesh.triangles = {{0, 1, 2}};
    mesh.material = MaterialId(0);
    scene.meshes.push_back(mesh);
  }
  return scene;
}

TEST(Validate, GoodScenePasses) {
  Scene scene = good_scene();
  const auto report = validate(scene);
  ASSERT_TRUE(report.ok()) << report.error().text();
  EXPECT_EQ(report.value().dropped_triangles, 0u);
}

TEST(Validate, NamesThePlaceOfEveryFault) {
  const struct {
    const char* where;
    std::function<void(Scene&)> spoil;
  } cases[] = {
      {"/size/0", [](Scene& s) { s.width = 0; }},
      {"/size/1", [](Scene& s) { s.height = 8193; }},
      {"/size", [](Scene& s) { s.width = s.height = 8192; }},
      {"/max_depth", [](Scene& s) { s.max_depth = 0; }},
      {"/max_depth", [](Scene& s) { s.max_depth = 129; }},
      {"/camera/position", [](Scene& s) { s.camera.position.y = kNan; }},
      {"/camera/target", [](Scene& s) { s.camera.target = s.camera.position; }},
      {"/camera/up", [](Scene& s) { s.camera.up = s.camera.target - s.camera.position; }},
      {"/camera/up",
       [](Scene& s) {
         s.camera.up = {0, 0, 0};
       }},
      {"/camera/vertical_fov_deg", [](Scene& s) { s.camera.vertical_fov_deg = 180; }},
      {"/camera/vertical_fov_deg", [](Scene& s) { s.camera.vertical_fov_deg = kNan; }},
      {"/camera/aperture_radius", [](Scene& s) { s.camera.aperture_radius = -1; }},
      {"/camera/focus_distance", [](Scene& s) { s.camera.focus_distance = kInf; }},
      {"/camera/height", [](Scene& s) { s.camera.height = -1; }},
      {"/environment/radiance", [](Scene& s) { s.environment.radiance.g = -1; }},
      {"/environment/to_world", [](Scene& s) { s.environment.to_world.rows[1].y = kNan; }},
      {"/environment/to_world", [](Scene& s) { s.environment.to_world.rows[2].z = 1.1f; }},
      {"/meshes/1/colors", [](Scene& s) { s.meshes[1].colors.resize(2); }},
      {"/meshes/1/colors/2",
       [](Scene& s) {
         s.meshes[1].colors = {Rgb{1}, Rgb{}, Rgb{1.1f}};
       }},
      {"/textures/0/uv_transform", [](Scene& s) { s.textures[0].uv_transform.u[2] = kNan; }},
      {"/instances/0/mesh", [](Scene& s) { s.instances[0].mesh = MeshId(2); }},
      {"/instances/0/mesh", [](Scene& s) { s.instances[0].mesh = {}; }},
      {"/instances/0/material", [](Scene& s) { s.instances[0].material = MaterialId(2); }},
      {"/instances/0/transform", [](Scene& s) { s.instances[0].to_world.rows[0] = {}; }},
      {"/instances/0/transform",
       [](Scene& s) { s.instances[0].to_world.rows[0][1] = double{kNan}; }},
      {"/instances/0/transform", [](Scene& s) { s.instances[0].to_world.rows[0][3] = 2e6; }},
      {"/lights/0/intensity", [](Scene& s) { s.lights[0].intensity.g = -1; }},
      {"/lights/0/position", [](Scene& s) { s.lights[0].position.y = kNan; }},
      {"/lights/1/direction",
       [](Scene& s) {
         s.lights[1].direction = {0, 0, 2};
       }},
      {"/lights/1/outer_deg", [](Scene& s) { s.lights[1].outer_rad = 0; }},
      {"/lights/1/outer_deg", [](Scene& s) { s.lights[1].outer_rad = 4; }},
      {"/lights/1/inner_deg", [](Scene& s) { s.lights[1].inner_rad = kNan; }},
      {"/lights/1/inner_deg", [](Scene& s) { s.lights[1].inner_rad = 1; }},
      {"/lights/2/irradiance", [](Scene& s) { s.lights[2].intensity.r = kInf; }},
      {"/lights/2/direction", [](Scene& s) { s.lights[2].direction.x = kNan; }},
      {"/environment/image", [](Scene& s) { s.environment.image = Image(2, 2, 1); }},
      {"/environment/image",
       [](Scene& s) {
         s.environment.image = Image(2, 2, 3);
         s.environment.image.at(1, 1, 2) = kInf;
       }},
      {"/materials/1/reflectance", [](Scene& s) { s.materials[1].reflectance.value.b = 1.5f; }},
      {"/materials/1/reflectance", [](Scene& s) { s.materials[1].reflectance.texture.value = 1; }},
      {"/materials/0/roughness", [](Scene& s) { s.materials[0].roughness.value = -0.1f; }},
      {"/materials/0/roughness", [](Scene& s) { s.materials[0].roughness.texture.value = 7; }},
      {"/materials/0/anisotropy", [](Scene& s) { s.materials[0].anisotropy.value = 2; }},
      {"/materials/0/anisotropy_rad", [](Scene& s) { s.materials[0].anisotropy_rad = kNan; }},
      {"/materials/0/eta", [](Scene& s) { s.materials[0].eta.r = kNan; }},
      {"/materials/0/k", [](Scene& s) { s.materials[0].k.r = 21; }},
      {"/materials/0/ior", [](Scene& s) { s.materials[0].ior = 0; }},
      {"/materials/0/specular", [](Scene& s) { s.materials[0].specular.value.r = 2; }},
      {"/materials/0/diffuse_transmission",
       [](Scene& s) { s.materials[0].diffuse_transmission.value = 2; }},
      {"/materials/0/iridescence", [](Scene& s) { s.materials[0].iridescence.value = -1; }},
      {"/materials/0/film_nm", [](Scene& s) { s.materials[0].film_nm.value = kNan; }},
      {"/materials/0/film_ior", [](Scene& s) { s.materials[0].film_ior = 0.5f; }},
      {"/materials/0/coat_normal_map",
       [](Scene& s) { s.materials[0].coat_normal_map = TextureId(7); }},
      {"/materials/0/sheen", [](Scene& s) { s.materials[0].sheen.value.r = 2; }},
      {"/materials/0/sheen_roughness", [](Scene& s) { s.materials[0].sheen_roughness.value = -1; }},
      {"/materials/0/transmittance", [](Scene& s) { s.materials[0].transmittance.value.r = 2; }},
      {"/materials/0/emission", [](Scene& s) { s.materials[0].emission.value.r = kInf; }},
      {"/materials/1/metallic", [](Scene& s) { s.materials[1].metallic.value = 1.5f; }},
      {"/materials/1/transmission", [](Scene& s) { s.materials[1].transmission.value = kNan; }},
      {"/materials/1/clearcoat", [](Scene& s) { s.materials[1].clearcoat.channel = 5; }},
      {"/materials/1/opacity", [](Scene& s) { s.materials[1].opacity.value = -1; }},
      {"/materials/1/opacity", [](Scene& s) { s.materials[1].opacity.channel = -1; }},
      {"/materials/1/alpha_cutoff", [](Scene& s) { s.materials[1].alpha_cutoff = 2; }},
      {"/materials/1/absorption", [](Scene& s) { s.materials[1].absorption.b = kInf; }},
      {"/materials/1/normal_map", [](Scene& s) { s.materials[1].normal_map = TextureId(9); }},
      {"/materials/1/normal_map/scale", [](Scene& s) { s.materials[1].normal_scale = kNan; }},
      {"/materials/1/bump_map", [](Scene& s) { s.materials[1].bump_map.value = 1e9f; }},
      {"/materials/0/emission", [](Scene& s) { s.materials[0].emission.texture.value = 3; }},
      {"/materials/1/second",
       [](Scene& s) {
         s.materials[1].kind = MaterialKind::kBlend;
         s.materials[1].first = MaterialId(0);
         s.materials[1].second = MaterialId(1);
       }},
      {"/materials/1/first", [](Scene& s) { s.materials[1].kind = MaterialKind::kBlend; }},
      {"/meshes/1/material", [](Scene& s) { s.meshes[1].material = MaterialId(2); }},
      {"/meshes/1/material", [](Scene& s) { s.meshes[1].material = {}; }},
      {"/meshes/1/normals", [](Scene& s) { s.meshes[1].normals.pop_back(); }},
      {"/meshes/1/uvs", [](Scene& s) { s.meshes[1].uvs.resize(4); }},
      {"/meshes/0/positions/2", [](Scene& s) { s.meshes[0].positions[2].z = kNan; }},
      {"/meshes/0/positions/1", [](Scene& s) { s.meshes[0].positions[1].x = 2e6f; }},
      {"/meshes/0/normals/1",
       [](Scene& s) {
         s.meshes[0].normals[1] = {0, 0, 2};
       }},
      {"/meshes/0/normals/0",
       [](Scene& s) {
         s.meshes[0].normals[0] = {0, 0, 0};
       }},
      {"/meshes/0/uvs/0", [](Scene& s) { s.meshes[0].uvs[0].y = kInf; }},
      {"/meshes/1/triangles/0", [](Scene& s) { s.meshes[1].triangles[0][1] = 3; }},
      {"/meshes",
       [](Scene& s) {
         s.meshes.clear();
         s.instances.clear();
       }},
  };
  for (const auto& c : cases) {
    Scene scene = good_scene();
    c.spoil(scene);
    const auto report = validate(scene);
    ASSERT_FALSE(report.ok()) << c.where;
    EXPECT_EQ(report.error().where, c.where) << report.error().text();
  }
}

TEST(Validate, SaysWhatWasExpectedAndWhatCame) {
  Scene scene = good_scene();
  scene.materials[1].ior = 0;
  EXPECT_EQ(validate(scene).error().text(), "/materials/1/ior: expected 1..4, got 0");
}

TEST(Validate, RefusesWhatIsOverItsLimits) {
  const struct {
    const char* where;
    SceneLimits limits;
  } cases[] = {{"/meshes", {.max_triangles = 1}},      {"/materials", {.max_materials = 1}},
               {"/lights", {.max_lights = 2}},         {"/instances", {.max_instances = 0}},
               {"/size/0", {.max_dimension_px = 511}}, {"/size", {.max_pixels = 512 * 512 - 1}}};
  for (const auto& c : cases) {
    Scene scene = good_scene();
    const auto report = validate(scene, c.limits);
    ASSERT_FALSE(report.ok()) << c.where;
    EXPECT_EQ(report.error().where, c.where);
  }
}

TEST(Validate, DropsTrianglesWithoutAreaAndEmptyMeshes) {
  Scene scene = good_scene();
  scene.meshes[0].triangles = {{0, 0, 1}, {0, 1, 2}, {1, 1, 1}};
  scene.meshes[1].triangles = {{2, 1, 2}};
  const auto report = validate(scene);
  ASSERT_TRUE(report.ok()) << report.error().text();
  EXPECT_EQ(report.value().dropped_triangles, 3u);
  ASSERT_EQ(scene.meshes.size(), 1u);
  EXPECT_EQ(scene.meshes[0].triangles, (std::vector<std::array<uint32_t, 3>>{{0, 1, 2}}));
  EXPECT_TRUE(scene.instances.empty());  // it was of the mesh that went

  scene = good_scene();
  scene.meshes[0].triangles.clear();
  ASSERT_TRUE(validate(scene).ok());
  ASSERT_EQ(scene.instances.size(), 1u);
  EXPECT_EQ(scene.instances[0].mesh, MeshId(0));  // where the second mesh is now
}

}  // namespace
}  // namespace qray
