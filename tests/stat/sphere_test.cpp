// Exact spheres: seen where they are, drawn as lights with the density that is told from outside
// and from inside, and as bright as fine triangles are.
#include <gtest/gtest.h>

#include "core/import/primitives.h"
#include "core/math/frame.h"
#include "tests/support/chi2.h"
#include "tests/support/near.h"
#include "tests/support/render.h"
#include "tests/support/stats.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

void add_sphere(Scene& scene, MaterialId material, const Sphere& sphere) {
  Mesh mesh;
  mesh.sphere = sphere;
  mesh.material = material;
  scene.meshes.push_back(mesh);
}

Sphere sphere_at(Vec3 center, float radius, bool inward = false) {
  return {center, radius, inward, Mat3{}};
}

Scene lamp(const Sphere& shape, bool two_sided) {
  Scene scene;
  const MaterialId light = test::add_material(scene, Rgb{0.0f}, Rgb{3.0f});
  scene.materials[light.value].emission_two_sided = two_sided;
  add_sphere(scene, light, shape);
  return scene;
}

// What a ray that starts there finds, if it is the light that sample() meant.
std::optional<Hit> hit_from(const PreparedScene& scene, Vec3 p, Vec3 wi) {
  Hit hit;
  return scene.accel->intersect({p, wi}, hit) ? std::optional(hit) : std::nullopt;
}

double density(const PreparedScene& scene, Vec3 p, Vec3 wi) {
  const std::optional<Hit> hit = hit_from(scene, p, wi);
  if (!hit) return 0;
  const SurfacePoint at = scene.surface_at({p, wi}, *hit);
  return static_cast<double>(scene.lights.pdf_w_of_hit({p, {}}, *hit, -dot(wi, at.ng)));
}

// From outside, all directions within the cone are alike, from inside all points of the sphere; and
// the density that is told is that of the draw, and 1 in all.
TEST(SphereLight, DirectionsFollowTheDensity) {
  const struct {
    const char* name;
    Vec3 p;
    bool inward, two_sided;
  } cases[] = {{"outside", {0.4f, 2.2f, 0.3f}, false, false},
               {"close outside", {0, 0, 1.02f}, false, false},
               {"far outside", {9, -4, 7}, false, true},
               {"inside", {0.3f, -0.6f, 0.2f}, true, false},
               {"inside, both sides shine", {0, 0.9f, 0}, false, true}};
  const double level = test::significance(2 * std::size(cases));
  for (const auto& c : cases) {
    const auto scene = test::prepare(lamp(sphere_at({0, 0, 0}, 1, c.inward), c.two_sided));
    const float distance = length(c.p);
    const Frame to_center(c.p / -distance);
    const float cap = 1 - std::sqrt(std::max(0.0f, 1 - 1 / sqr(distance)));
    const test::Chi2 result = test::chi2_square(
        [&](test::Random& random) -> std::optional<Vec2> {
          LightSample light;
          const float u_light = random.next();
          if (!scene->lights.sample({c.p, {}}, u_light, random.next_2d(), light))
            return std::nullopt;
          // At the very edge a ray may pass.
          if (const auto hit = hit_from(*scene, c.p, light.wi)) {
            EXPECT_NEAR(light.distance / hit->t, 1, 2e-3) << c.name;
            EXPECT_NEAR(density(*scene, c.p, light.wi) / light.pdf_w, 1, 2e-3) << c.name;
          }
          const Vec3 on_sphere = c.p + light.wi * light.distance;
          const Vec3 local = distance > 1 ? to_center.to_local(light.wi) : on_sphere;
          const float turn = std::atan2(local.y, local.x) / (2 * kPi);
          return Vec2{std::clamp((1 - local.z) / (distance > 1 ? cap : 2), 0.0f, kOneMinusEpsilon),
                      std::clamp(turn + 0.5f, 0.0f, kOneMinusEpsilon)};
        },
        [](Vec2) { return 1.0; });
    EXPECT_GT(result.p_value, level) << c.name << result.table;
    test::Moments whole;
    test::Random random(77);
    for (int i = 0; i < 400'000; ++i) {
      const Vec3 wi = square_to_uniform_sphere(random.next_2d());
      whole.add(density(*scene, c.p, wi) * 4 * static_cast<double>(kPi));
    }
    EXPECT_GT(test::z_test(whole, 1).p_value, level) << c.name << ": " << whole.mean();
  }
}

TEST(SphereLight, NothingComesFromTheSideThatIsDark) {
  test::Random random(5);
  const auto outward = test::prepare(lamp(sphere_at({0, 0, 0}, 1), false));
  const auto inward = test::prepare(lamp(sphere_at({0, 0, 0}, 1, true), false));
  for (int i = 0; i < 100; ++i) {
    LightSample light;
    EXPECT_FALSE(outward->lights.sample({{0.5f, 0, 0}, {}}, 0.5f, random.next_2d(), light));
    EXPECT_FALSE(inward->lights.sample({{1.5f, 0, 0}, {}}, 0.5f, random.next_2d(), light));
  }
}

TEST(Sphere, IsHitWhereItIs) {
  Scene scene;
  Sphere shape = sphere_at({3, -2, 1}, 0.7f);
  Mesh turned;
  turned.sphere = shape;
  const Transform turn = Transform::rotation({1, 2, 3}, 50);
  turn.apply(turned);
  turned.material = test::add_material(scene, Rgb{0.5f});
  scene.meshes.push_back(turned);
  const Vec3 center = turn.point(shape.center);
  const auto prepared = test::prepare(scene);
  test::Random random(2);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 n = square_to_uniform_sphere(random.next_2d());
    const Vec3 target = center + n * 0.7f, from = target + n * 5.0f * random.next();
    const std::optional<Hit> hit = hit_from(*prepared, from, -n);
    ASSERT_TRUE(hit);
    const SurfacePoint at = prepared->surface_at({from, -n}, *hit);
    EXPECT_LT(length(at.p - target), 4e-6f);
    EXPECT_GT(dot(at.ng, n), 1 - 1e-6f);
    // The poles went along: u and v are those of the normal before the turn.
    const Vec3 before = turn.normals().transposed() * n;
    const Vec2 uv = turned.sphere->uv(n), expected = shape.uv(normalize(before));
    EXPECT_NEAR(uv.y, expected.y, 1e-5f);
    if (std::abs(uv.y - 0.5f) < 0.45f) {
      EXPECT_NEAR(std::remainder(uv.x - expected.x, 1.0f), 0, 1e-5f);
    }
    // Inside, the far side is hit.
    const std::optional<Hit> far = hit_from(*prepared, center + n * 0.1f, -n);
    ASSERT_TRUE(far);
    EXPECT_NEAR(far->t, 0.8f, 1e-5f);
  }
}

TEST(Sphere, TangentsAreTheSlopesOfUv) {
  Mesh mesh;
  mesh.sphere = sphere_at({1, 2, 3}, 0.5f);
  Transform::rotation({0, 1, 0}, 30).apply(mesh);
  const Sphere& shape = *mesh.sphere;
  test::Random random(8);
  for (int i = 0; i < 200; ++i) {
    const Vec3 n = square_to_uniform_sphere(random.next_2d());
    const Vec2 uv = shape.uv(n);
    if (std::abs(uv.y - 0.5f) > 0.45f || std::abs(uv.x - 0.5f) > 0.48f) continue;
    const auto [du, dv] = shape.tangents(n);
    constexpr float kStep = 1e-2f;
    const Vec2 along_u = shape.uv(normalize(n + du * (kStep / shape.radius / length(du))));
    EXPECT_NEAR((along_u.x - uv.x) / (kStep / length(du)), 1, 0.05f);
    const Vec2 along_v = shape.uv(normalize(n + dv * (kStep / shape.radius / length(dv))));
    EXPECT_NEAR((along_v.y - uv.y) / (kStep / length(dv)), 1, 0.05f);
  }
}

TEST(Sphere, StretchedOnesAreNotKept) {
  EXPECT_TRUE(
      Transform::scaling({-2, 2, 2}).after(Transform::rotation({1, 1, 0}, 20)).keeps_spheres());
  EXPECT_FALSE(Transform::scaling({2, 2, 2.01f}).keeps_spheres());
  Transform sheared;
  sheared.rows[0][1] = 0.01;
  EXPECT_FALSE(sheared.keeps_spheres());
}

// A glass ball, a rough mirror, and a lamp that is round, in a room.
Scene balls(bool exact) {
  Scene scene = test::room();
  const MaterialId glass = test::add_material(scene, Rgb{1.0f});
  scene.materials[glass.value].kind = MaterialKind::kDielectric;
  const MaterialId metal = test::add_material(scene, Rgb{0.9f});
  scene.materials[metal.value].kind = MaterialKind::kConductor;
  scene.materials[metal.value].roughness.value = 0.3f;
  const MaterialId light = test::add_material(scene, Rgb{0.0f}, {2, 9, 4});
  const auto add = [&](MaterialId material, Vec3 center, float radius) {
    if (exact) return add_sphere(scene, material, sphere_at(center, radius));
    Mesh mesh = make_sphere(center, radius, 5);
    mesh.material = material;
    scene.meshes.push_back(mesh);
  };
  add(glass, {-0.4f, 0.3f, 0.2f}, 0.3f);
  add(metal, {-0.5f, 1.1f, -0.5f}, 0.35f);
  add(light, {0.5f, 1.3f, 0.1f}, 0.15f);
  return scene;
}

TEST(Sphere, AFineOneOfTrianglesLooksTheSame) {
  const auto exact = test::prepare(balls(true)), fine = test::prepare(balls(false));
  constexpr int kRegions = 4;
  const double level = test::significance(2 * kRegions * kRegions);
  for (const bool nee : {true, false}) {
    std::vector<test::Moments> of_exact(kRegions * kRegions), of_fine = of_exact;
    for (uint64_t seed = 1; seed <= 16; ++seed) {
      RenderSettings settings = test::small_settings("none", 48, nee ? 16 : 48, seed);
      settings.nee = nee;
      settings.max_depth = 6;
      const auto add = [&](const PreparedScene& scene, std::vector<test::Moments>& to) {
        const auto means = test::region_luminances(test::render(scene, settings).image, kRegions);
        for (size_t i = 0; i < means.size(); ++i) to[i].add(means[i]);
      };
      add(*exact, of_exact);
      settings.seed += 100;
      add(*fine, of_fine);
    }
    for (size_t i = 0; i < of_exact.size(); ++i) {
      EXPECT_GT(test::z_test(of_exact[i], of_fine[i]).p_value, level)
          << "nee " << nee << ", region " << i << ": " << of_exact[i].mean() << " +- "
          << of_exact[i].standard_error() << ", triangles " << of_fine[i].mean() << " +- "
          << of_fine[i].standard_error();
    }
  }
}

// In a vast scene rays start further off a surface. They must not meet the edge of the lamp that
// they are meant for: it did in 4 of 100.
TEST(Sphere, ALampInAVastSceneIsAsBrightAsInASmallOne) {
  const auto lit = [](bool vast) {
    Scene scene;
    add_sphere(scene, test::add_material(scene, Rgb{0.0f}, Rgb{30.0f}),
               sphere_at({1, 2.2f, 1}, 0.2f));
    const MaterialId ground = test::add_material(scene, Rgb{0.6f});
    test::add_quad(scene, ground, {-20, 0, 20}, {40, 0, 0}, {0, 0, -40});
    if (vast) test::add_quad(scene, ground, {0, -1500, 0}, {0, 1, 0}, {0, 0, 1});
    scene.camera.position = {0, 1, 4};
    scene.camera.target = {0, 0.5f, 0};
    return test::prepare(scene);
  };
  const auto small = lit(false), vast = lit(true);
  ASSERT_GT(vast->ray_epsilon, 20 * small->ray_epsilon);
  test::Moments of_small, of_vast;
  for (uint64_t seed = 1; seed <= 12; ++seed) {
    of_small.add(test::mean_luminance(
        test::render(*small, test::small_settings("none", 48, 64, seed)).image));
    of_vast.add(test::mean_luminance(
        test::render(*vast, test::small_settings("none", 48, 64, seed + 100)).image));
  }
  EXPECT_NEAR(of_vast.mean() / of_small.mean(), 1, 2e-3)
      << of_vast.standard_error() / of_vast.mean();
}

}  // namespace
}  // namespace qray
