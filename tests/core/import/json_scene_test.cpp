#include "core/import/json_scene.h"

#include <gtest/gtest.h>

#include "tests/core/import/scene_text.h"

namespace qray {
namespace {

const std::string kCamera =
    R"("camera": {"position": [0, 1, 3], "target": [0, 1, 0], "vertical_fov_deg": 40})";
const std::string kMaterials = R"("materials": [{"name": "a", "type": "diffuse"}])";
const std::string kMeshes =
    R"("meshes": [{"material": "a",
                   "quad": {"origin": [0,0,0], "edge1": [0,0,1], "edge2": [1,0,0]}}])";

std::string document(const std::string& camera, const std::string& materials,
                     const std::string& meshes, const std::string& more = "") {
  return "{" + camera + "," + materials + "," + meshes + (more.empty() ? "" : "," + more) + "}";
}
std::string with_materials(const std::string& list) {
  return document(kCamera, "\"materials\": [" + list + "]", kMeshes);
}
std::string with_mesh(const std::string& mesh) {
  return document(kCamera, kMaterials, "\"meshes\": [" + mesh + "]");
}
std::string with(const std::string& more) { return document(kCamera, kMaterials, kMeshes, more); }

TEST(JsonScene, ReadsEveryFieldWhereItBelongs) {
  const test::SceneFolder folder;
  folder.write("t.png", "not opened here");
  const auto loaded = folder.load(
      "scene.json",
      document(
          R"("name": "n", "size": [64, 48], "max_depth": 7,
         "camera": {"position": [1, 2, 3], "target": [0, 0, 0], "up": [0, 0, 1],
                    "vertical_fov_deg": 33, "aperture_radius": 0.5, "focus_distance": 4,
                    "mirrored": true})",
          R"("textures": [{"name": "t", "path": "t.png", "srgb": false, "wrap": "clamp"},
                           {"name": "w", "path": "t.png", "wrap": ["clamp", "mirror"],
                            "nearest": true, "uv_transform": [1, 2, 3, 4, 5, 6]}],
         "materials": [
           {"name": "d", "type": "diffuse", "reflectance": {"texture": "t", "scale": 0.5},
            "emission": [1, 2, 3], "emission_two_sided": true},
           {"name": "c", "type": "conductor", "metal": "silver", "roughness": 0.2, "specular": 0.9},
           {"name": "e", "type": "conductor", "eta": [1, 2, 3], "k": 4},
           {"name": "g", "type": "dielectric", "ior": 1.3},
           {"name": "p", "type": "plastic", "reflectance": [0.1, 0.2, 0.3],
            "roughness": {"texture": "t"}}])",
          R"("environment": {"radiance": 2, "rotation_deg": 30},
         "lights": [{"type": "point", "position": [1, 2, 3], "intensity": 4},
                    {"type": "spot", "position": [1, 2, 4], "direction": [0, -2, 0],
                     "intensity": [1, 2, 3], "inner_deg": 45, "outer_deg": 90,
                     "falloff": "linear_angle"},
                    {"type": "directional", "direction": [0, 0, 3], "irradiance": 5}],
         "meshes": [{"name": "m", "material": "p",
                     "positions": [[0,0,0],[1,0,0],[1,1,0],[0,1,0]], "quads": [[0,1,2,3]],
                     "uvs": [[0,0],[1,0],[1,1],[0,1]],
                     "colors": [[0,0,0],[1,0,0],[1,1,0.5],[0,1,0]],
                     "normals": [[0,0,1],[0,0,1],[0,0,9],[0,0,1]]}])"));
  ASSERT_TRUE(loaded.ok()) << loaded.error().text();
  const Scene& s = loaded.value().scene;
  EXPECT_EQ(s.name, "n");
  EXPECT_EQ(s.width, 64);
  EXPECT_EQ(s.height, 48);
  EXPECT_EQ(s.max_depth, 7);
  EXPECT_EQ(s.camera, (Camera{{1, 2, 3}, {0, 0, 0}, {0, 0, 1}, 33, 0.5f, 4, true}));
  ASSERT_EQ(s.textures.size(), 2u);
  EXPECT_EQ(s.textures[0].path, folder.path() / "t.png");
  EXPECT_FALSE(s.textures[0].srgb);
  EXPECT_EQ(s.textures[0].wrap_v, TextureWrap::kClamp);
  EXPECT_FALSE(s.textures[0].nearest);
  EXPECT_EQ(s.textures[1].wrap_u, TextureWrap::kClamp);
  EXPECT_EQ(s.textures[1].wrap_v, TextureWrap::kMirror);
  EXPECT_TRUE(s.textures[1].nearest);
  EXPECT_EQ(s.textures[1].uv_transform, (UvTransform{{1, 2, 3}, {4, 5, 6}}));
  ASSERT_EQ(s.materials.size(), 5u);
  EXPECT_EQ(s.materials[0].reflectance, (ColorParam{Rgb{0.5f}, TextureId(0)}));
  EXPECT_EQ(s.materials[0].emission.value, (Rgb{1, 2, 3}));
  EXPECT_TRUE(s.materials[0].emission_two_sided);
  EXPECT_EQ(s.materials[1].kind, MaterialKind::kConductor);
  EXPECT_LT(max_component(s.materials[1].eta), 0.1f);  // silver
  EXPECT_EQ(s.materials[1].roughness.value, 0.2f);
  EXPECT_EQ(s.materials[1].specular.value, Rgb{0.9f});
  EXPECT_EQ(s.materials[2].eta, (Rgb{1, 2, 3}));
  EXPECT_EQ(s.materials[2].k, Rgb{4});
  EXPECT_EQ(s.materials[3].kind, MaterialKind::kDielectric);
  EXPECT_EQ(s.materials[3].ior, 1.3f);
  EXPECT_EQ(s.materials[4].kind, MaterialKind::kPlastic);
  EXPECT_EQ(s.materials[4].roughness, (FloatParam{1, TextureId(0)}));
  EXPECT_EQ(s.environment.radiance, Rgb{2});
  EXPECT_EQ(s.environment.to_world, Mat3::rotation_y(30));
  ASSERT_EQ(s.lights.size(), 3u);
  EXPECT_EQ(s.lights[0].kind, LightKind::kPoint);
  EXPECT_EQ(s.lights[0].position, (Vec3{1, 2, 3}));
  EXPECT_EQ(s.lights[0].intensity, Rgb{4});
  EXPECT_EQ(s.lights[1].kind, LightKind::kSpot);
  EXPECT_EQ(s.lights[1].direction, (Vec3{0, -1, 0}));
  EXPECT_EQ(s.lights[1].intensity, (Rgb{1, 2, 3}));
  EXPECT_FLOAT_EQ(s.lights[1].inner_rad, kPi / 4);
  EXPECT_FLOAT_EQ(s.lights[1].outer_rad, kPi / 2);
  EXPECT_EQ(s.lights[1].falloff, SpotFalloff::kLinearAngle);
  EXPECT_EQ(s.lights[2].kind, LightKind::kDirectional);
  EXPECT_EQ(s.lights[2].direction, (Vec3{0, 0, 1}));
  EXPECT_EQ(s.lights[2].intensity, Rgb{5});
  ASSERT_EQ(s.meshes.size(), 1u);
  EXPECT_EQ(s.meshes[0].name, "m");
  EXPECT_EQ(s.meshes[0].material, MaterialId(4));
  EXPECT_EQ(s.meshes[0].triangles, (std::vector<std::array<uint32_t, 3>>{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(s.meshes[0].normals[2], (Vec3{0, 0, 1}));
  EXPECT_EQ(s.meshes[0].uvs[2], (Vec2{1, 1}));
  EXPECT_EQ(s.meshes[0].colors[2], (Rgb{1, 1, 0.5f}));
}

TEST(JsonScene, ExactSpheresAreTurnedAndScaledAndKeepThePolesUp) {
  const test::SceneFolder folder;
  const auto read = [&](const std::string& more) {
    return folder.load("scene.json", document(kCamera, kMaterials,
                                              R"("meshes": [{"name": "ball",
        "material": "a", "sphere": {"center": [1, 0, 0], "radius": 2, "exact": true})" +
                                                  more));
  };
  const auto loaded = read(R"(, "flip": true, "transform": {"scale": 3, "rotate": {"axis":
      [0, 0, 1], "deg": 90}, "translate": [0, 0, 5]}}])");
  ASSERT_TRUE(loaded.ok()) << loaded.error().text();
  ASSERT_TRUE(loaded.value().scene.meshes[0].sphere);
  const Sphere& sphere = *loaded.value().scene.meshes[0].sphere;
  EXPECT_LT(length(sphere.center - Vec3{0, 3, 5}), 1e-5f);
  EXPECT_FLOAT_EQ(sphere.radius, 6);
  EXPECT_TRUE(sphere.inward);
  EXPECT_NEAR(sphere.uv({-1, 0, 0}).y, 1, 1e-3f);  // +y, turned
  const auto instanced = read(R"(}], "instances": [{"mesh": "ball"}])");
  ASSERT_FALSE(instanced.ok());
  EXPECT_EQ(instanced.error().text(),
            "scene.json:/instances/0/mesh: expected a mesh of triangles, got an exact sphere");
}

TEST(JsonScene, ReadsEveryKindOfMaterial) {
  const test::SceneFolder folder;
  folder.write("t.png", "not opened here");
  const auto loaded = folder.load("scene.json", document(kCamera, R"(
      "textures": [{"name": "t", "path": "t.png", "srgb": false}],
      "materials": [
        {"name": "a", "type": "thin_dielectric", "ior": 1.3, "specular": {"texture": "t"}},
        {"name": "g", "type": "dielectric", "absorption": [1, 2, 3], "two_sided": false,
         "transmittance": 0.25},
        {"name": "m", "type": "plastic", "nonlinear": false},
        {"name": "p", "type": "principled", "reflectance": 0.9, "ior": 1.4, "roughness": 0.3,
         "metallic": {"texture": "t", "scale": 0.5, "channel": "b"}, "transmission": 0.25,
         "thin": true, "disney": true, "specular": 20, "specular_weight": 0.75, "clearcoat": 0.125,
         "clearcoat_roughness": 0.0625, "absorption": 4, "sheen": [0.25, 0.5, 0.75],
         "sheen_roughness": {"texture": "t", "channel": "a"}, "anisotropy_directions": true,
         "diffuse_transmission": 0.5, "diffuse_transmission_color": [0.75, 0.5, 0.25],
         "iridescence": 0.125, "film_ior": 1.5, "film_nm": 500, "film_least_nm": 200,
         "coat_normal_map": {"texture": "t", "scale": 0.5}},
        {"name": "b", "type": "blend", "first": "p", "second": "g",
         "weight": {"texture": "t", "channel": "a"}, "opacity": 0.5, "alpha_cutoff": 0.25,
         "normal_map": {"texture": "t", "scale": 2}, "bump_map": {"texture": "t", "scale": 0.01},
         "emission": {"texture": "t", "scale": [1, 2, 3]}}])",
                                                         kMeshes));
  ASSERT_TRUE(loaded.ok()) << loaded.error().text();
  const std::vector<Material>& m = loaded.value().scene.materials;
  ASSERT_EQ(m.size(), 5u);
  const TextureId t(0);
  EXPECT_EQ(m[0].kind, MaterialKind::kThinDielectric);
  EXPECT_EQ(m[0].specular, (ColorParam{Rgb{1}, t}));
  EXPECT_EQ(m[0].transmittance, m[0].specular);
  EXPECT_EQ(m[1].specular.value, Rgb{1});
  EXPECT_EQ(m[1].transmittance.value, Rgb{0.25f});
  EXPECT_EQ(m[1].absorption, (Rgb{1, 2, 3}));
  EXPECT_FALSE(m[1].two_sided);
  EXPECT_FALSE(m[2].nonlinear);
  EXPECT_TRUE(m[1].nonlinear);
  EXPECT_EQ(m[3].kind, MaterialKind::kPrincipled);
  EXPECT_EQ(m[3].metallic, (FloatParam{0.5f, t, 2}));
  EXPECT_EQ(m[3].transmission.value, 0.25f);
  EXPECT_TRUE(m[3].thin);
  EXPECT_TRUE(m[3].disney);
  EXPECT_EQ(m[3].specular.value, Rgb{20});
  EXPECT_EQ(m[3].specular_weight.value, 0.75f);
  EXPECT_EQ(m[3].clearcoat.value, 0.125f);
  EXPECT_EQ(m[3].clearcoat_roughness.value, 0.0625f);
  EXPECT_EQ(m[3].absorption, Rgb{4});
  EXPECT_EQ(m[3].sheen.value, (Rgb{0.25f, 0.5f, 0.75f}));
  EXPECT_EQ(m[3].sheen_roughness, (FloatParam{1, t, 3}));
  EXPECT_TRUE(m[3].anisotropy_directions);
  EXPECT_EQ(m[3].diffuse_transmission.value, 0.5f);
  EXPECT_EQ(m[3].diffuse_transmission_color.value, (Rgb{0.75f, 0.5f, 0.25f}));
  EXPECT_EQ(m[3].iridescence.value, 0.125f);
  EXPECT_EQ(m[3].film_ior, 1.5f);
  EXPECT_EQ(m[3].film_nm.value, 500);
  EXPECT_EQ(m[3].film_least_nm, 200);
  EXPECT_TRUE(m[3].own_coat_normal);
  EXPECT_EQ(m[3].coat_normal_map, t);
  EXPECT_EQ(m[3].coat_normal_scale, 0.5f);
  EXPECT_EQ(m[4].kind, MaterialKind::kBlend);
  EXPECT_EQ(m[4].first, MaterialId(3));
  EXPECT_EQ(m[4].second, MaterialId(1));
  EXPECT_EQ(m[4].blend_weight, (FloatParam{1, t, 3}));
  EXPECT_EQ(m[4].opacity.value, 0.5f);
  EXPECT_EQ(m[4].alpha_cutoff, 0.25f);
  EXPECT_EQ(m[4].normal_map, t);
  EXPECT_EQ(m[4].normal_scale, 2.0f);
  EXPECT_EQ(m[4].bump_map, (FloatParam{0.01f, t}));
  EXPECT_EQ(m[4].emission, (ColorParam{Rgb{1, 2, 3}, t}));
}

TEST(JsonScene, InstancesPlaceAllMeshesOfAName) {
  const test::SceneFolder folder;
  folder.write("two.obj", "o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no b\nf 1 2 3\n");
  const auto read = [&](const std::string& instances) {
    return folder.load("scene.json",
                       document(kCamera, R"("materials": [{"name": "a", "type": "diffuse"},
                                                          {"name": "b", "type": "diffuse"}])",
                                R"("meshes": [{"name": "chair", "material": "a", "file": "two.obj"},
                                   {"name": "x", "material": "a", "disk": {"center": [0,0,0],
                                    "normal": [0,1,0], "radius": 1}},
                                   {"name": "x", "material": "a", "disk": {"center": [0,0,0],
                                    "normal": [0,1,0], "radius": 1}}], "instances": )" +
                                    instances));
  };
  const auto loaded = read(R"([{"mesh": "chair"},
                               {"mesh": "chair", "material": "b",
                                "transform": {"translate": [0, 2, 0]}}])");
  ASSERT_TRUE(loaded.ok()) << loaded.error().text();
  const Scene& s = loaded.value().scene;
  const size_t parts = s.meshes.size() - 2;
  ASSERT_EQ(s.instances.size(), 2 * parts);
  EXPECT_FALSE(s.instances[0].material.valid());
  EXPECT_EQ(s.instances.back().material, MaterialId(1));
  EXPECT_EQ(s.instances.back().mesh.value, parts - 1);
  EXPECT_EQ(s.instances.back().to_world.point({1, 0, 0}), (Vec3{1, 2, 0}));
  EXPECT_EQ(s.bounds().hi.y, 3);
  EXPECT_EQ(s.placements()[0].mesh, nullptr);
  const auto twice = read(R"([{"mesh": "x"}])");
  ASSERT_FALSE(twice.ok());
  EXPECT_EQ(twice.error().text(),
            "scene.json:/instances/0/mesh: expected the name of one mesh, got \"x\"");
  const auto far = read(R"([{"mesh": "chair"}, {"mesh": "chair",
                            "transform": {"scale": 1e6, "translate": [1e6, 0, 0]}}])");
  ASSERT_FALSE(far.ok());
  EXPECT_TRUE(far.error().text().starts_with("scene.json:/instances/1/transform: expected a place"))
      << far.error().text();
}

TEST(JsonScene, EveryProjectionHasItsMembers) {
  const test::SceneFolder folder;
  const auto camera = [&](const std::string& members) {
    return folder.load("scene.json", document("\"camera\": {\"position\": [0, 1, 3], "
                                              "\"target\": [0, 1, 0], " +
                                                  members + "}",
                                              kMaterials, kMeshes));
  };
  const auto parallel = camera(R"("projection": "orthographic", "height": 2.5)");
  ASSERT_TRUE(parallel.ok()) << parallel.error().text();
  EXPECT_EQ(parallel.value().scene.camera.projection, Projection::kOrthographic);
  EXPECT_EQ(parallel.value().scene.camera.height, 2.5f);
  const auto around = camera(R"("projection": "equirectangular", "mirrored": true)");
  ASSERT_TRUE(around.ok()) << around.error().text();
  EXPECT_EQ(around.value().scene.camera.projection, Projection::kEquirectangular);
  for (const auto& [members, error] : std::vector<std::pair<std::string, std::string>>{
           {R"("projection": "fisheye")",
            "/projection: expected perspective, orthographic or equirectangular, got \"fisheye\""},
           {R"("projection": "orthographic")", ": \"height\" is missing"},
           {R"("projection": "orthographic", "height": 0)",
            "/height: expected a length over 0, got 0"},
           {R"("vertical_fov_deg": 40, "height": 2)", "/height: unknown field"},
           {R"("projection": "equirectangular", "aperture_radius": 1)",
            "/aperture_radius: unknown field"}}) {
    const auto loaded = camera(members);
    ASSERT_FALSE(loaded.ok()) << members;
    EXPECT_TRUE(loaded.error().text().starts_with("scene.json:/camera" + error))
        << loaded.error().text();
  }
}

TEST(JsonScene, AnisotropyIsInDegrees) {
  const test::SceneFolder folder;
  const auto loaded = folder.load(
      "scene.json", with_materials(R"({"name": "a", "type": "conductor", "metal": "gold",
        "roughness": 0.3, "anisotropy": 0.7, "anisotropy_deg": -90})"));
  ASSERT_TRUE(loaded.ok()) << loaded.error().text();
  EXPECT_EQ(loaded.value().scene.materials[0].anisotropy.value, 0.7f);
  EXPECT_NEAR(loaded.value().scene.materials[0].anisotropy_rad, -kPi / 2, 1e-6f);
}

TEST(JsonScene, NamesThePlaceOfEveryFault) {
  const struct {
    std::string text;
    const char* error;
  } cases[] = {
      {with(R"("colour": 1)"), "scene.json:/colour: unknown field, expected one of: "},
      {document(R"("camera": {"target": [0,0,0], "vertical_fov_deg": 40})", kMaterials, kMeshes),
       "scene.json:/camera: \"position\" is missing"},
      {document(R"("camera": {"position": [0,0,0,1], "target": [0,0,0], "vertical_fov_deg": 40})",
                kMaterials, kMeshes),
       "scene.json:/camera/position: expected an array of 3 numbers, got an array of 4"},
      {document(R"("camera": {"position": [0,0,3], "target": [0,0,0], "vertical_fov_deg": 0})",
                kMaterials, kMeshes),
       "scene.json:/camera/vertical_fov_deg: expected more than 0 and less than 180, got 0"},
      {with(R"("size": [512, 0.5])"), "scene.json:/size/1: expected an integer, 1..8192, got 0.5"},
      {with(R"("max_depth": "8")"),
       "scene.json:/max_depth: expected an integer, 1..128, got \"8\""},
      {with_materials(R"({"name": "a", "type": "diffuse"}, {"name": "a", "type": "diffuse"})"),
       "scene.json:/materials/1/name: \"a\" is taken"},
      {with_materials(R"({"name": "a", "type": "velvet"})"),
       "scene.json:/materials/0/type: expected one of diffuse, conductor, dielectric, "
       "thin_dielectric, plastic, principled, blend, got \"velvet\""},
      {with_materials(R"({"name": "a", "type": "diffuse"},
                         {"name": "b", "type": "blend", "first": "a", "second": "b"})"),
       "scene.json:/materials/1/second: expected the name of a material before this one, got "
       "\"b\""},
      {with_materials(R"({"name": "a", "type": "diffuse"}, {"name": "b", "type": "dielectric",
                         "ior": 0})"),
       "scene.json:/materials/1/ior: expected 1..4, got 0"},
      {with_materials(R"({"name": "a", "type": "diffuse", "ior": 1.5})"),
       "scene.json:/materials/0/ior: unknown field"},
      {with_materials(R"({"name": "a", "type": "diffuse", "reflectance": {"texture": "t"}})"),
       "scene.json:/materials/0/reflectance/texture: expected the name of a texture, got \"t\""},
      {with_materials(R"({"name": "a", "type": "conductor", "metal": "tin"})"),
       "scene.json:/materials/0/metal: expected one of aluminium, copper, gold, silver, got "
       "\"tin\""},
      {with_materials(R"({"name": "a", "type": "conductor", "metal": "gold", "k": 1})"),
       "scene.json:/materials/0/k: expected either \"metal\" or \"eta\" and \"k\""},
      {with(R"("textures": [{"name": "t", "path": "gone.png"}])"),
       "scene.json:/textures/0/path: no such file in the scene's folder: \"gone.png\""},
      {with(R"("environment": {"image": "gone.exr"})"),
       "scene.json:/environment/image: no such file"},
      {with(R"("environment": {"image": "sky.png"})"),
       "scene.json:/environment/image: expected an .exr or .hdr file, got \"sky.png\""},
      {with(R"("instances": [{"mesh": "m"}])"),
       "scene.json:/instances/0/mesh: expected the name of one mesh, got \"m\""},
      {with(R"("instances": [{"mesh": "m", "flip": true}])"),
       "scene.json:/instances/0/flip: unknown field"},
      {with(R"("lights": [{"type": "laser"}])"),
       "scene.json:/lights/0/type: expected one of point, spot, directional, got \"laser\""},
      {with(
           R"("lights": [{"type": "point", "position": [0,0,0], "intensity": 1, "inner_deg": 1}])"),
       "scene.json:/lights/0/inner_deg: unknown field"},
      {with_mesh(R"({"material": "b", "quad": {"origin": [0,0,0], "edge1": [0,0,1],
                     "edge2": [1,0,0]}})"),
       "scene.json:/meshes/0/material: expected the name of a material, got \"b\""},
      {with_mesh(R"({"material": "a"})"), "scene.json:/meshes/0: expected one of \"positions\""},
      {with_mesh(R"({"material": "a", "box": {"min": [0,0,0], "max": [1,1,1]}, "file": "x.obj"})"),
       "scene.json:/meshes/0/box: expected one shape a mesh"},
      {with_mesh(R"({"material": "a", "box": {"min": [0,0,0], "max": [1,0,1]}})"),
       "scene.json:/meshes/0/box/max: expected more than \"min\""},
      {with_mesh(R"({"material": "a", "positions": [[0,0,0],[1,0,0],[0,1,0]],
                     "triangles": [[0,1,3]]})"),
       "scene.json:/meshes/0/triangles/0/2: expected an integer, 0..2, got 3"},
      {with_mesh(R"({"material": "a", "positions": [[0,0,0],[1,0],[0,1,0]],
                     "triangles": [[0,1,2]]})"),
       "scene.json:/meshes/0/positions/1: expected an array of 3 numbers, got an array of 2"},
      {with_mesh(R"({"material": "a", "positions": [[0,0,0],[1,0,0],[0,1,0]],
                     "triangles": [[0,1,2]], "uvs": [[0,0]]})"),
       "scene.json:/meshes/0/uvs: expected 3, one a position, got 1"},
      {with_mesh(R"({"material": "a", "sphere": {"center": [0,0,0], "radius": 0}})"),
       "scene.json:/meshes/0/sphere/radius: expected 1e-06..1e+06, got 0"},
      {with_mesh(R"({"material": "a", "sphere": {"center": [0,0,0], "radius": 1, "exact": true,
                     "smooth": true}})"),
       "scene.json:/meshes/0/sphere/smooth: expected only without \"exact\""},
      {with_mesh(R"({"material": "a", "sphere": {"center": [0,0,0], "radius": 1, "exact": true},
                     "transform": {"scale": [1, 2, 1]}})"),
       "scene.json:/meshes/0/transform: expected one scale for all directions"},
      {with_mesh(R"({"material": "a", "box": {"min": [0,0,0], "max": [1,1,1]},
                     "transform": {"scale": [1, 0, 1]}})"),
       "scene.json:/meshes/0/transform/scale/1: expected a factor of 1e-6 or more in size, got 0"},
      {with_mesh(R"({"material": "a", "box": {"min": [0,0,0], "max": [1,1,1]},
                     "transform": {"matrix": [1,0,0,0, 2,0,0,0, 0,0,1,0, 0,0,0,1]}})"),
       "scene.json:/meshes/0/transform: expected a map that keeps volume"},
      {with_mesh(R"({"file": "gone.obj"})"),
       "scene.json:/meshes/0/file: no such file in the scene's folder: \"gone.obj\""},
  };
  const test::SceneFolder folder;
  for (const auto& c : cases) {
    const std::string failure = folder.failure("scene.json", c.text);
    EXPECT_EQ(failure.substr(0, std::string_view(c.error).size()), c.error) << c.text;
  }
}

TEST(JsonScene, FilesOutsideOfItsFolderAreRefused) {
  const test::SceneFolder folder;
  const auto outside = folder.write("out.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  folder.write("in/deep/a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  std::filesystem::create_symlink(outside, folder.write("in/x", "").parent_path() / "link.obj");
  for (const std::string& name : {std::string("../out.obj"), outside.string(),
                                  std::string("deep/../../out.obj"), std::string("link.obj")}) {
    EXPECT_EQ(folder.failure("in/scene.json", with_mesh(R"({"file": ")" + name + "\"}")),
              "scene.json:/meshes/0/file: no such file in the scene's folder: \"" + name + "\"");
  }
}

TEST(JsonScene, AFileOfSeveralMeshesKeepsItsPlaceInErrors) {
  const test::SceneFolder folder;
  folder.write("two.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\ng a\nf 1 2 3\ng b\nf 3 2 1\n");
  const std::string far = R"({"material": "a", "box": {"min": [0,0,0], "max": [1,1,1]},
                              "transform": {"scale": 1e6, "translate": [1,0,0]}})";
  EXPECT_EQ(folder.failure("scene.json", with_mesh(R"({"file": "two.obj"}, )" + far)).substr(0, 35),
            "scene.json:/meshes/1/positions/2: e");
}

TEST(JsonScene, FilesBringTheirMaterialsUnlessOneIsGiven) {
  const test::SceneFolder folder;
  folder.write("m.mtl", "newmtl red\nKd 1 0 0\nnewmtl lamp\nKe 5 5 5\n");
  folder.write("m.obj",
               "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\nusemtl lamp\n"
               "f 1 3 2\n");
  const auto own = folder.load("scene.json", with_mesh(R"({"name": "n", "file": "m.obj"})"));
  ASSERT_TRUE(own.ok()) << own.error().text();
  const Scene& s = own.value().scene;
  ASSERT_EQ(s.meshes.size(), 2u);
  EXPECT_EQ(s.materials[s.meshes[0].material.value].reflectance.value, (Rgb{1, 0, 0}));
  EXPECT_TRUE(s.materials[s.meshes[1].material.value].emits());
  const auto given =
      folder.load("scene.json", with_mesh(R"({"material": "a", "file": "m.obj", "flip": true})"));
  ASSERT_TRUE(given.ok()) << given.error().text();
  EXPECT_EQ(given.value().scene.materials.size(), 1u);
  EXPECT_EQ(given.value().scene.meshes[0].material, MaterialId(0));
  EXPECT_EQ(test::front(given.value().scene.meshes[0], 0), (Vec3{0, 0, -1}));
}

TEST(JsonScene, MirroringKeepsTheFrontAndFlipTurnsIt) {
  const std::string quad = R"("quad": {"origin": [0,0,0], "edge1": [1,0,0], "edge2": [0,1,0]})";
  const struct {
    std::string more;
    Vec3 front;
  } cases[] = {{"", {0, 0, 1}},
               {R"(, "transform": {"scale": [-1, 1, 1]})", {0, 0, 1}},
               {R"(, "transform": {"scale": [1, 1, -1]})", {0, 0, -1}},
               {R"(, "flip": true)", {0, 0, -1}}};
  const test::SceneFolder folder;
  for (const auto& c : cases) {
    const auto loaded =
        folder.load("scene.json", with_mesh(R"({"material": "a", )" + quad + c.more + "}"));
    ASSERT_TRUE(loaded.ok()) << loaded.error().text();
    EXPECT_EQ(test::front(loaded.value().scene.meshes[0], 0), c.front) << c.more;
  }
}

}  // namespace
}  // namespace qray
