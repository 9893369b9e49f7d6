// Lights are picked with the density that is told, and next event estimation changes the noise of a
// picture, not its mean, whatever the light and the surface.
#include <gtest/gtest.h>

#include "tests/support/chi2.h"
#include "tests/support/render.h"
#include "tests/support/stats.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

// A dim sky with a small bright sun, some rows dark.
Image sky() {
  Image image(32, 16, 3);
  test::Random random(3);
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 32; ++x) image.set_rgb(x, y, Rgb{0.2f + 0.3f * random.next()});
  image.set_rgb(20, 4, {60, 50, 40});
  return image;
}

Scene ground_under(const Image& image, float rotation_deg) {
  Scene scene;
  scene.name = "ground";
  test::add_quad(scene, test::add_material(scene, Rgb{0.6f}), {-2, 0, -2}, {0, 0, 4}, {4, 0, 0});
  test::add_box(scene, test::add_material(scene, {0.7f, 0.3f, 0.3f}), {-0.4f, 0, -0.4f},
                {0.4f, 0.9f, 0.4f}, false);
  scene.environment.radiance = Rgb{1.0f};
  scene.environment.image = image;
  scene.environment.to_world = Mat3::rotation_y(rotation_deg);
  scene.camera.position = {0, 1.6f, 3};
  scene.camera.target = {0, 0.4f, 0};
  return scene;
}

Scene glossy_room(MaterialKind kind, float roughness) {
  Scene scene = test::room();
  for (Material& m : scene.materials)
    if (!m.emits()) {
      m.kind = kind;
      m.roughness.value = roughness;
    }
  return scene;
}

Scene room_with_a_panel_that_shines_both_ways() {
  Scene scene = test::room();
  for (Material& m : scene.materials)
    if (m.emits()) m.emission_two_sided = true;
  for (Mesh& mesh : scene.meshes)
    if (scene.materials[mesh.material.value].emits())
      for (Vec3& p : mesh.positions) p.y = 1.5f;
  return scene;
}

// Most of what it lights it lights at a grazing angle.
Scene room_with_a_panel_that_shines_at_the_ceiling() {
  Scene scene = test::room();
  for (Mesh& mesh : scene.meshes)
    if (scene.materials[mesh.material.value].emits()) flip_winding(mesh);
  return scene;
}

// The light's density over the sphere, as seen from a point that lights reach unhindered.
TEST(LightSampling, EnvironmentDirectionsFollowTheDensity) {
  for (float rotation : {0.0f, 130.0f}) {
    const auto scene = test::prepare(ground_under(sky(), rotation));
    const LightPick& lights = scene->lights;
    test::Chi2Options options;
    options.tolerance = 1e-5;
    const test::Chi2 result = test::chi2_sphere(
        [&](test::Random& random) -> std::optional<Vec3> {
          LightSample light;
          const float u_light = random.next();
          if (!lights.sample({{0, 2, 0}, {}}, u_light, random.next_2d(), light))
            return std::nullopt;
          EXPECT_NEAR(light.pdf_w / lights.from_environment(light.wi).pdf_w, 1, 1e-3);
          return light.wi;
        },
        [&](Vec3 wi) { return lights.from_environment(wi).pdf_w; }, options);
    EXPECT_GT(result.p_value, test::significance(2)) << result.table;
  }
}

TEST(LightSampling, TheSunIsWhereTheRotationPutsIt) {
  // Texel (20, 4) of 32 x 16: 50.6 degrees right of the picture's centre (-z), 39.4 above the
  // horizon.
  const float azimuth = (20.5f / 32 - 0.5f) * 2 * kPi, height = (0.5f - 4.5f / 16) * kPi;
  const Vec3 sun{std::sin(azimuth) * std::cos(height), std::sin(height),
                 -std::cos(azimuth) * std::cos(height)};
  const auto plain = test::prepare(ground_under(sky(), 0));
  EXPECT_GT(plain->lights.environment_radiance(sun).r, 50);
  const auto turned = test::prepare(ground_under(sky(), 90));  // -z goes to -x
  EXPECT_GT(turned->lights.environment_radiance({sun.z, sun.y, -sun.x}).r, 50);
}

struct Case {
  std::string name;
  Scene scene;
  int samples;
  bool guided = false;  // with `huang`, too: tests/stability has no such light
};

std::vector<Case> cases() {
  return {{"area light", test::room(), 16},
          {"light that shines up", test::room(/*shaded=*/true), 32},
          {"panel that shines at the ceiling", room_with_a_panel_that_shines_at_the_ceiling(), 64},
          {"panel that shines both ways", room_with_a_panel_that_shines_both_ways(), 16, true},
          {"image environment", ground_under(sky(), 40), 32, true},
          {"constant environment", ground_under({}, 0), 16, true},
          {"rough metal", glossy_room(MaterialKind::kConductor, 0.5f), 32},
          {"rough plastic", glossy_room(MaterialKind::kPlastic, 0.4f), 32},
          {"smooth plastic", glossy_room(MaterialKind::kPlastic, 0), 32}};
}

test::Moments means(const PreparedScene& scene, const Case& c, const std::string& method,
                    bool nee) {
  constexpr int kSide = 32;
  constexpr uint64_t kSeeds = 24;
  test::Moments means;
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    RenderSettings settings =
        test::small_settings(method, kSide, c.samples, seed + (nee ? 100 : 0));
    settings.nee = nee;
    settings.max_depth = 6;
    means.add(test::mean_luminance(test::render(scene, settings).image));
  }
  return means;
}

TEST(LightSampling, PickingLightsAlikeAndRouletteOffKeepTheMean) {
  // A second, small and strong light: by power it is picked more often than not.
  Scene two_lights = test::room();
  const MaterialId strong = test::add_material(two_lights, Rgb{0.0f}, Rgb{2000.0f});
  test::add_quad(two_lights, strong, {-0.9f, 1.2f, -0.9f}, {0.1f, 0, 0}, {0, 0, 0.1f});
  const auto scene = test::prepare(two_lights);
  ASSERT_FALSE(scene->lights.picks_uniformly());
  ASSERT_TRUE(scene->lights.uniform().picks_uniformly());
  test::Moments plain, alike, no_roulette;
  for (uint64_t seed = 1; seed <= 24; ++seed) {
    RenderSettings settings = test::small_settings("none", 32, 32, seed);
    plain.add(test::mean_luminance(test::render(*scene, settings).image));
    settings.seed += 100;
    settings.light_table = false;
    alike.add(test::mean_luminance(test::render(*scene, settings).image));
    settings.seed += 100;
    settings.light_table = true;
    settings.russian_roulette = false;
    no_roulette.add(test::mean_luminance(test::render(*scene, settings).image));
  }
  EXPECT_GT(test::z_test(plain, alike).p_value, test::significance(2));
  EXPECT_GT(test::z_test(plain, no_roulette).p_value, test::significance(2));
  EXPECT_LT(plain.variance(), alike.variance());
}

TEST(LightSampling, NextEventEstimationKeepsTheMean) {
  const double level = test::significance(2 * static_cast<int>(cases().size()));
  for (const Case& c : cases()) {
    const auto scene = test::prepare(c.scene);
    for (const char* method : {"none", "huang"}) {
      if (!c.guided && method != std::string_view("none")) continue;
      const test::Moments with = means(*scene, c, method, true);
      const test::Moments without = means(*scene, c, method, false);
      EXPECT_GT(test::z_test(with, without).p_value, level)
          << c.name << ", " << method << ": " << with.mean() << " +- " << with.standard_error()
          << " with, " << without.mean() << " +- " << without.standard_error() << " without";
      EXPECT_LT(with.standard_error(), 0.05 * with.mean()) << c.name;
    }
  }
}

}  // namespace
}  // namespace qray
