// A scene of instances is the same scene as with its meshes written out, at a fraction of the
// memory.
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "core/import/primitives.h"
#include "tests/support/random.h"
#include "tests/support/render.h"
#include "tests/support/stats.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

// The instances' meshes at their places, in their order.
Scene written_out(const Scene& scene) {
  Scene out = scene;
  out.meshes.clear();
  out.instances.clear();
  for (const Placement& placed : scene.placements()) {
    if (!placed.mesh) continue;
    Mesh mesh = *placed.mesh;
    if (placed.to_world) placed.to_world->apply(mesh);
    mesh.material = placed.material;
    out.meshes.push_back(std::move(mesh));
  }
  return out;
}

// A room of a ball, a squeezed rock and a mirrored ball of glass, that a mirrored and a turned
// panel light from their fronts alone.
Scene room_of_instances() {
  Scene scene = test::room();
  scene.meshes.pop_back();
  const MaterialId light(2);
  const MaterialId glass = test::add_material(scene, Rgb{1});
  scene.materials[glass.value].kind = MaterialKind::kDielectric;
  Mesh ball = make_sphere({5, 0, 0}, 1, 3);  // its own space need not be the room's
  ball.material = MaterialId(1);
  const MeshId ball_id(static_cast<uint32_t>(scene.meshes.size()));
  scene.meshes.push_back(ball);
  Mesh rock = make_sphere({5, 0, 0}, 1, 1);  // flat
  rock.normals.clear();
  rock.material = MaterialId(0);
  const MeshId rock_id(static_cast<uint32_t>(scene.meshes.size()));
  scene.meshes.push_back(rock);
  Mesh panel = make_quad({0, 0, 0}, {1, 0, 0}, {0, 0, 1});
  panel.material = light;
  const MeshId panel_id(static_cast<uint32_t>(scene.meshes.size()));
  scene.meshes.push_back(panel);
  const auto add = [&](MeshId mesh, Vec3 scale, Vec3 axis, float deg, Vec3 to, MaterialId m = {}) {
    scene.instances.push_back({mesh,
                               Transform::translation(to)
                                   .after(Transform::rotation(axis, deg))
                                   .after(Transform::scaling(scale))
                                   .after(Transform::translation({-5, 0, 0})),
                               m});
  };
  add(ball_id, {0.3f, 0.3f, 0.3f}, {0, 1, 0}, 0, {-0.6f, 0.3f, -0.3f});
  add(rock_id, {0.2f, 0.4f, 0.1f}, {1, 1, 0}, 50, {0, 0.6f, 0}, MaterialId(1));
  add(ball_id, {-0.25f, 0.25f, 0.25f}, {0, 0, 1}, 20, {0.4f, 1.2f, -0.3f}, glass);
  scene.instances.push_back(
      {panel_id,
       Transform::translation({-0.25f, 1.98f, -0.25f}).after(Transform::scaling({0.5f, -1, 0.5f})),
       {}});
  scene.instances.push_back({panel_id,
                             Transform::translation({-0.9f, 1.5f, -0.2f})
                                 .after(Transform::rotation({0, 0, 1}, -90))
                                 .after(Transform::scaling({0.2f, 1, 0.2f})),
                             {}});
  return scene;
}

TEST(Instances, AreTheSameSceneAsItsMeshesWrittenOut) {
  const Scene instances = room_of_instances(), meshes = written_out(instances);
  EXPECT_EQ(instances.placed_triangle_count(), meshes.triangle_count());
  EXPECT_LT(instances.triangle_count(), meshes.triangle_count());
  const auto a = test::prepare(instances), b = test::prepare(meshes);
  for (const bool nee : {true, false}) {
    for (const char* method : {"none", "adaptive"}) {
      RenderSettings settings = test::small_settings(method, 48, 32);
      settings.nee = nee;
      const Image x = test::render(*a, settings).image, y = test::render(*b, settings).image;
      // The same random numbers: where rounding parts no path, pixels are alike. But a mirrored
      // panel written out has its triangles' corners in another order, and so other light points.
      int alike = 0;
      for (int v = 0; v < 48; ++v)
        for (int u = 0; u < 48; ++u)
          alike += std::abs(luminance(x.rgb(u, v)) - luminance(y.rgb(u, v))) <=
                   1e-3f * luminance(y.rgb(u, v)) + 1e-5f;
      if (std::string(method) == "none" && !nee) {
        EXPECT_GT(alike, 0.75 * 48 * 48);
      }
      EXPECT_NEAR(test::mean_luminance(x) / test::mean_luminance(y), 1, nee ? 0.01 : 0.1)
          << method << nee;
      EXPECT_GT(test::mean_luminance(x), 0.02) << method;
    }
  }
}

TEST(Instances, HitsTellTheInstanceAndItsNormals) {
  const Scene scene = room_of_instances();
  const auto instances = test::prepare(scene), meshes = test::prepare(written_out(scene));
  test::Random random(1);
  int seen = 0;
  for (int i = 0; i < 20'000; ++i) {
    const Vec3 o{random.next() * 1.8f - 0.9f, random.next() * 1.8f + 0.1f, 0.9f};
    const Ray ray{o, square_to_uniform_sphere(random.next_2d())};
    Hit hit, same;
    const bool any = instances->accel->intersect(ray, hit);
    ASSERT_EQ(any, meshes->accel->intersect(ray, same));
    if (!any || hit.mesh.value < scene.meshes.size()) continue;
    ++seen;
    // Of the written out meshes, those of the room come first, then the instances.
    EXPECT_EQ(hit.mesh.value - scene.meshes.size(), same.mesh.value - (scene.meshes.size() - 3));
    if (hit.triangle != same.triangle) continue;  // an edge, by rounding
    const SurfacePoint p = instances->surface_at(ray, hit), q = meshes->surface_at(ray, same);
    EXPECT_LT(length(p.p - q.p), 1e-4f);
    EXPECT_LT(length(p.ng - q.ng), 1e-3f);
    EXPECT_LT(length(p.ns - q.ns), 1e-3f);
  }
  EXPECT_GT(seen, 500);
}

// What lets half of the light pass does so where it is an instance, and only there.
TEST(Instances, LetPassWhatIsNotOpaque) {
  Scene scene;
  const MaterialId white = test::add_material(scene, Rgb{0.5f}),
                   pane = test::add_material(scene, Rgb{0.5f});
  scene.materials[pane.value].opacity.value = 0.5f;
  test::add_quad(scene, white, {-4, 0, -4}, {0, 0, 8}, {8, 0, 0});
  test::add_quad(scene, white, {-1, 5, -1}, {0, 0, 2}, {2, 0, 0});
  scene.instances = {{MeshId(1), Transform::translation({-2, 0, 0}), {}},
                     {MeshId(1), Transform::translation({2, 0, 0}), pane}};
  PunctualLight sun;
  sun.kind = LightKind::kDirectional;
  sun.direction = {0, -1, 0};
  sun.intensity = Rgb{kPi};
  scene.lights = {sun};
  const auto prepared = test::prepare(scene);
  for (const auto& [x, expected] : {std::pair{-2.0f, 0.0}, {2.0f, 0.25}, {0.0f, 0.5}}) {
    RenderSettings settings = test::small_settings("none", 16, 64);
    settings.max_depth = 2;  // lit straight alone
    Camera camera;
    camera.position = {x, 1, 0.5f};
    camera.target = {x, 0, 0};
    camera.vertical_fov_deg = 10;
    settings.camera = camera;
    EXPECT_NEAR(test::mean_luminance(test::render(*prepared, settings).image), expected, 0.02) << x;
  }
}

size_t resident_bytes() {
  size_t total = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> total >> resident;
  return resident * static_cast<size_t>(sysconf(_SC_PAGESIZE));
}

TEST(Instances, AThousandOfTenThousandTrianglesTakeLessThan60Megabytes) {
  Scene scene;
  test::add_material(scene, Rgb{0.5f});
  Mesh mesh = make_cylinder({0, 0, 0}, 1, 0.5f, 0.5f, 2500, true);  // 10,000 triangles
  mesh.material = MaterialId(0);
  ASSERT_GE(mesh.triangles.size(), 10'000u);
  scene.meshes.push_back(mesh);
  for (int i = 0; i < 1000; ++i) {
    const auto x = static_cast<float>(i % 32), z = static_cast<float>(i / 32);
    scene.instances.push_back(
        {MeshId(0),
         Transform::translation({2 * x, 0, 2 * z}).after(Transform::rotation({0, 1, 0}, 7.0f * x)),
         {}});
  }
  scene.environment.radiance = Rgb{1};
  scene.camera.position = {-3, 5, -3};
  scene.camera.target = {10, 0, 10};
  const size_t before = resident_bytes();
  const auto prepared = test::prepare(scene);
  const Image image = test::render(*prepared, test::small_settings("none", 64, 4)).image;
  EXPECT_LT(resident_bytes() - before, 60u << 20);
  EXPECT_GT(test::mean_luminance(image), 0.1);
  EXPECT_EQ(prepared->scene.placed_triangle_count(), 1000 * mesh.triangles.size());
}

}  // namespace
}  // namespace qray
