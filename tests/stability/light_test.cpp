// What light alone can do to a method: none at all, none that its table saw, far too much or
// little.
#include <gtest/gtest.h>

#include "tests/stability/compare.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

using test::formatted;

constexpr int kLightSide = 24;  // pixels

TEST(Light, NoneAtAll) {
  const test::FailureMode mode("no-light");
  Scene dark = test::room();
  test::scale_emission(dark, 0);
  const auto scene = test::prepare(std::move(dark));
  for (const std::string& method : test::compared_methods()) {
    const test::Rendered r = test::render(*scene, test::variant_settings(method, kLightSide, 16));
    const RenderStats& stats = r.job.stats;
    for (float v : r.image.data()) ASSERT_EQ(v, 0.0f) << method;
    EXPECT_EQ(stats.dropped_samples, 0u) << method;
    EXPECT_EQ(stats.rays, 0u) << method;
    EXPECT_EQ(stats.states, 0u) << method;
    mode.says(method, formatted("a black picture, %d rays, %d states", static_cast<int>(stats.rays),
                                static_cast<int>(stats.states)));
  }
}

// A room behind whose left wall is a chamber, open to the room through a hole of `hole` metres.
Scene room_with_chamber(float hole) {
  Scene scene;
  const MaterialId white = test::add_material(scene, Rgb{0.7f});
  test::add_box(scene, white, {-3, 0, -1}, {1, 2, 1}, true);
  const float y = 1 - hole / 2, z = hole / 2;
  const auto wall = [&](float y0, float y1, float z0, float z1) {
    test::add_quad(scene, white, {-1, y0, z0}, {0, y1 - y0, 0}, {0, 0, z1 - z0});
  };
  wall(0, y, -1, 1);
  wall(y + hole, 2, -1, 1);
  wall(y, y + hole, -1, -z);
  wall(y, y + hole, z, 1);
  scene.camera.position = {-0.7f, 1.2f, 0.9f};
  scene.camera.target = {0.6f, 0.8f, -0.5f};
  scene.camera.vertical_fov_deg = 70;
  return scene;
}

struct Unseen {
  const char* name;
  Scene scene;
  MaterialId hidden;  // dark while the table learns
  double open_guide_error = 1.1;
};

std::vector<Unseen> unseen_lights() {
  std::vector<Unseen> cases;
  const auto add = [&](const char* name, Scene scene) -> Unseen& {
    const MaterialId dim = test::add_material(scene, {}, Rgb{2});
    const MaterialId hidden = test::add_material(scene, {});
    test::add_quad(scene, dim, {0.4f, 1.98f, -0.3f}, {0.5f, 0, 0}, {0, 0, 0.5f});
    return cases.emplace_back(name, std::move(scene), hidden);
  };
  const auto light = [](Unseen& at, Rgb emission, Vec3 origin, Vec3 edge1, Vec3 edge2) {
    at.scene.materials[at.hidden.value].emission.value = emission;
    test::add_quad(at.scene, at.hidden, origin, edge1, edge2);
  };
  light(add("tiny", test::room()), Rgb{2e4f}, {-0.8f, 0.5f, -0.9f}, {0.01f, 0, 0}, {0, 0.01f, 0});
  // A 1 m window to a lamp 200 m away.
  Unseen& far = add("far", room_with_chamber(1));
  far.scene.meshes.erase(far.scene.meshes.begin() + 4);  // the chamber's outer wall
  light(far, Rgb{4e3f}, {-200, -5, -5}, {0, 10, 0}, {0, 0, 10});
  Unseen& pinhole = add("behind a pinhole", room_with_chamber(0.15f));
  pinhole.open_guide_error = 1.5;  // measured: 1.37
  light(pinhole, Rgb{300}, {-2.5f, 1.9f, -0.5f}, {1, 0, 0}, {0, 0, 1});
  return cases;
}

TEST(Light, TheTableHasNeverSeen) {
  const test::FailureMode mode("unseen-light");
  for (Unseen& c : unseen_lights()) {
    Scene dark = c.scene;
    dark.materials[c.hidden.value].emission.value = {};
    const auto before = test::prepare(std::move(dark)), now = test::prepare(std::move(c.scene));
    RenderSettings settings = test::small_settings("none", kLightSide, 16);
    test::SeedOptions options;
    options.open_guide_error = c.open_guide_error;
    options.table = [&](const std::string& variant) {
      return test::render(*before, test::variant_settings(variant, kLightSide, 64, 99)).job.table;
    };
    test::check_methods(mode, c.name, *now, settings, options);
  }
}

TEST(Light, FarTooMuchOrTooLittle) {
  const test::FailureMode mode("extreme-emission");
  const RenderSettings settings = test::small_settings("none", kLightSide, 32);
  const test::SeedOptions options{.seeds = 8, .regions = 2, .table = {}};
  const auto room = test::prepare(test::room(true));
  const Image reference = test::reference_of(*room, settings, 16);
  for (const std::string& method : test::compared_methods()) {
    const test::Sampled usual = test::sample_seeds(*room, settings, method, options, &reference);
    // The room's lamp has 20. With powers of two a picture that is only scaled has the same bits.
    for (const auto& [scale, label] :
         {std::pair{0x1p30f, "emission times 2^30"}, std::pair{0x1p-37f, "emission times 2^-37"}}) {
      Scene changed = test::room(true);
      test::scale_emission(changed, scale);
      const test::Sampled scaled = test::sample_seeds(*test::prepare(std::move(changed)), settings,
                                                      method, options, &reference, 1 / scale);
      const std::string where = usual.method + ", " + label;
      EXPECT_EQ(scaled.dropped_samples, 0u) << where;
      const double z = test::expect_same_means(scaled, usual, where);
      const double error = test::median(scaled.relmse) / test::median(usual.relmse);
      EXPECT_NEAR(error, 1, 0.02) << where;
      mode.mean(method, label, formatted("z %.1f", z));
      mode.error(method, label, formatted("%.3f", error));
    }
  }
}

}  // namespace
}  // namespace qray
