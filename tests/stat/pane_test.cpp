// Light through panes: sampling of lights passes them straight, and adds up with what paths find.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tests/support/render.h"
#include "tests/support/stats.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

constexpr Rgb kTint{0.9f, 0.5f, 0.2f};

Material pane(MaterialKind kind, Rgb tint) {
  Material m;
  m.kind = kind;
  m.transmittance.value = tint;
  m.reflectance.value = tint;
  m.transmission.value = 1;
  m.thin = true;
  m.roughness.value = 0;
  return m;
}

// What a pane of index 1.5 lets pass, by Fresnel's and Stokes' formulas.
double passed_by_pane(double cosine) {
  const double sine_t = std::sqrt(1 - cosine * cosine) / 1.5;
  const double cosine_t = std::sqrt(1 - sine_t * sine_t);
  const double s = (cosine - 1.5 * cosine_t) / (cosine + 1.5 * cosine_t);
  const double p = (1.5 * cosine - cosine_t) / (1.5 * cosine + cosine_t);
  const double face = (s * s + p * p) / 2;
  return 1 - 2 * face / (1 + face);
}

// A room whose lamp is above a ceiling of eight panes, each of a kind of its own, with two more
// below it.
Scene room_under_panes() {
  Scene scene = test::room();
  const auto add = [&](Material m) {
    m.name = "pane" + std::to_string(scene.materials.size());
    scene.materials.push_back(m);
    return MaterialId(static_cast<uint32_t>(scene.materials.size() - 1));
  };
  const MaterialId clear = add(pane(MaterialKind::kThinDielectric, Rgb{1.0f}));
  const MaterialId tinted = add(pane(MaterialKind::kThinDielectric, kTint));
  Material veil = pane(MaterialKind::kThinDielectric, Rgb{0.8f});
  veil.opacity.value = 0.7f;
  Material half = pane(MaterialKind::kPrincipled, kTint);
  half.transmission.value = 0.6f;  // else it is diffuse
  Material coated = pane(MaterialKind::kPrincipled, Rgb{0.9f});
  coated.clearcoat.value = 1;
  Material blend;
  blend.kind = MaterialKind::kBlend;
  blend.first = clear;
  blend.second = MaterialId(0);
  const std::array<MaterialId, 8> kinds{clear,       tinted,     add(veil), add(half),
                                        add(coated), add(blend), clear,     tinted};
  for (size_t i = 0; i < kinds.size(); ++i) {
    const float x = -1 + 0.5f * static_cast<float>(i % 4), z = i < 4 ? -1.0f : 0.0f;
    test::add_quad(scene, kinds[i], {x, 1.7f, z}, {0.5f, 0, 0}, {0, 0, 1});
  }
  // Normals as of a curved pane; an instance that is stretched and turned.
  Mesh& curved = scene.meshes[scene.meshes.size() - 2];
  curved.normals = {normalize({-0.3f, -1, 0}), normalize({0.3f, -1, 0}), normalize({0.3f, -1, 0}),
                    normalize({-0.3f, -1, 0})};
  test::add_quad(scene, tinted, {-0.5f, 0, -0.5f}, {1, 0, 0}, {0, 0, 1});
  Instance instance;
  instance.mesh = MeshId(static_cast<uint32_t>(scene.meshes.size() - 1));
  instance.material = tinted;
  instance.to_world = Transform::translation({-0.4f, 1.4f, 0.1f})
                          .after(Transform::rotation({0, 0, 1}, 25))
                          .after(Transform::scaling({1, 1, 0.6f}));
  scene.instances.push_back(instance);
  test::add_quad(scene, clear, {0.1f, 1.2f, -0.6f}, {0.7f, 0.1f, 0}, {0, 0.2f, 0.9f});
  return scene;
}

constexpr int kPaneRegions = 4;  // of a side

std::vector<test::Moments> under_panes(const PreparedScene& scene, const std::string& method,
                                       bool nee, uint64_t first_seed) {
  constexpr int kSide = 32, kSeeds = 16;
  std::vector<test::Moments> regions(kPaneRegions * kPaneRegions);
  for (uint64_t seed = first_seed; seed < first_seed + kSeeds; ++seed) {
    RenderSettings settings = test::small_settings(method, kSide, 32, seed);
    settings.nee = nee;
    settings.max_depth = 3;  // what passes panes counts for both alike
    const std::vector<double> means =
        test::region_luminances(test::render(scene, settings).image, kPaneRegions);
    for (size_t i = 0; i < means.size(); ++i) regions[i].add(means[i]);
  }
  return regions;
}

TEST(Pane, RaysToLightsAndPathsFindTheSameLight) {
  const auto scene = test::prepare(room_under_panes());
  const double level = test::significance(2 * kPaneRegions * kPaneRegions);
  const std::vector<test::Moments> paths = under_panes(*scene, "none", false, 1);
  for (const char* method : {"none", "adaptive"}) {
    const std::vector<test::Moments> both = under_panes(*scene, method, true, 101);
    double variance = 0, variance_of_paths = 0;
    for (size_t i = 0; i < both.size(); ++i) {
      EXPECT_GT(test::z_test(both[i], paths[i]).p_value, level)
          << method << ", region " << i << ": " << both[i].mean() << " +- "
          << both[i].standard_error() << ", paths alone " << paths[i].mean() << " +- "
          << paths[i].standard_error();
      variance += both[i].variance(), variance_of_paths += paths[i].variance();
    }
    EXPECT_LT(variance, 0.5 * variance_of_paths) << method;
  }
}

TEST(Pane, TheSunShinesThroughInItsColours) {
  for (const MaterialKind kind : {MaterialKind::kThinDielectric, MaterialKind::kPrincipled}) {
    Scene scene;
    scene.name = "floor";
    test::add_quad(scene, test::add_material(scene, Rgb{0.8f}), {-9, 0, -9}, {0, 0, 18},
                   {18, 0, 0});
    scene.materials.push_back(pane(kind, kTint));
    scene.materials.back().name = "pane";
    test::add_quad(scene, MaterialId(1), {-40, 20, -40}, {0, 0, 80}, {80, 0, 0});
    PunctualLight sun;
    sun.kind = LightKind::kDirectional;
    sun.direction = normalize({0.5f, -1, 0.2f});
    sun.intensity = Rgb{2.0f};
    scene.lights = {sun};
    scene.camera.position = {0, 10, 0};
    scene.camera.target = {0, 0, 0};
    scene.camera.up = {0, 0, -1};
    scene.camera.vertical_fov_deg = 10;
    RenderSettings settings = test::small_settings("none", 8, 4);
    settings.max_depth = 2;
    const Image image = test::render(*test::prepare(std::move(scene)), settings).image;
    const double cosine = double{-sun.direction.y};
    // Principled's is Schlick's formula, of one face.
    const double passed = kind == MaterialKind::kThinDielectric
                              ? passed_by_pane(cosine)
                              : 0.96 * (1 - std::pow(1 - cosine, 5));
    for (int c = 0; c < 3; ++c) {
      const double expected = 2 * cosine * passed * double{kTint[c]} * 0.8 * double{kInvPi};
      EXPECT_NEAR(image.rgb(4, 4)[c], expected, 1e-3 * expected) << c;
    }
  }
}

}  // namespace
}  // namespace qray
