// Paths that aim at where mirrors and glass send light from: directions follow their density,
// pictures keep their mean by region, and the noise of focused light falls.
#include <gtest/gtest.h>

#include <cmath>

#include "core/render/caustic_map.h"
#include "tests/support/chi2.h"
#include "tests/support/render.h"
#include "tests/support/stats.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

constexpr int kCausticRegions = 4;

enum class Focus { kBall, kMirror, kBallOnMetal };

// A floor under a glass ball that focuses a small lamp on it. kMirror: a mirror beside the floor
// instead of the ball; kBallOnMetal: the floor has wide lobes and no base.
Scene focused_light(Focus focus) {
  const bool mirror = focus == Focus::kMirror;
  Scene scene;
  const MaterialId floor = test::add_material(scene, Rgb{0.5f});
  const MaterialId lamp = test::add_material(scene, Rgb{0.0f}, Rgb{400.0f});
  Material clear;
  clear.name = "clear";
  clear.kind = mirror ? MaterialKind::kConductor : MaterialKind::kDielectric;
  scene.materials.push_back(clear);
  const MaterialId glass(static_cast<uint32_t>(scene.materials.size() - 1));
  test::add_quad(scene, floor, {-1, 0, -1}, {0, 0, 2}, {2, 0, 0});
  test::add_quad(scene, lamp, {-0.03f, 1.5f, -0.03f}, {0.06f, 0, 0}, {0, 0, 0.06f});
  if (mirror) {
    test::add_quad(scene, glass, {0.9f, 0, -0.3f}, {0, 0, 0.6f}, {0, 0.6f, 0});
  } else {
    Mesh ball;
    ball.sphere.emplace();
    ball.sphere->center = {0, 0.45f, 0};
    ball.sphere->radius = 0.3f;
    ball.material = glass;
    scene.meshes.push_back(ball);
  }
  if (focus == Focus::kBallOnMetal) {
    Material& metal = scene.materials[floor.value];
    metal.kind = MaterialKind::kConductor;
    metal.roughness.value = 0.8f;
  }
  scene.camera.position = {0, 1.2f, 1.8f};
  scene.camera.target = {0, 0, 0};
  scene.camera.vertical_fov_deg = 45;
  scene.width = scene.height = 32;
  return scene;
}

TEST(CausticMap, DirectionsFollowTheirDensity) {
  test::Random random(3);
  std::array<CausticMap::Lobes, 2> both;
  for (size_t i = 0; i < CausticMap::kLobes; ++i)
    for (CausticMap::Lobes* lobes : {&both[0], &both[1]}) {
      lobes->x[i] = random.next() - 0.5f, lobes->y[i] = random.next() - 0.5f;
      lobes->z[i] = lobes == &both[0] ? 2 + random.next() : random.next() - 0.5f;
      lobes->radius[i] = 0.1f + 0.9f * random.next();
    }
  for (const CausticMap::Lobes& lobes : both) {
    const Vec3 p{0.1f, -0.2f, 0.05f};
    const test::Chi2 chi2 = test::chi2_sphere(
        [&](test::Random& r) { return CausticMap::sample(lobes, p, r.next_2d()); },
        [&](Vec3 wi) { return double{CausticMap::pdf_w(lobes, p, wi)}; });
    EXPECT_GT(chi2.p_value, test::significance(2)) << chi2.table;
    EXPECT_NEAR(chi2.integral, 1, 1e-3);
  }
}

TEST(CausticMap, ThreadsChangeNothing) {
  const auto scene = test::prepare(focused_light(Focus::kBall));
  TaskPool one(1), three(3);
  CausticPhotons a = send_photons(*scene, one), b = send_photons(*scene, three);
  send_nearby(a, *scene, one);
  send_nearby(b, *scene, three);
  ASSERT_EQ(a.photons.size(), b.photons.size());
  ASSERT_GT(a.photons.size(), 1000u);
  for (size_t i = 0; i < a.photons.size(); ++i) {
    ASSERT_EQ(a.photons[i].p.x, b.photons[i].p.x);
    ASSERT_EQ(a.photons[i].from.z, b.photons[i].from.z);
  }
}

TEST(CausticMap, OnlyWhereMirrorsOrGlassFocusLight) {
  TaskPool pool(2);
  EXPECT_EQ(test::prepare(test::room())->caustics(pool), nullptr);
  const auto scene = test::prepare(focused_light(Focus::kBall));
  const size_t bytes_before = scene->size_bytes();
  const CausticMap* map = scene->caustics(pool);
  ASSERT_NE(map, nullptr);
  EXPECT_GE(scene->size_bytes(), bytes_before + map->size_bytes());
  EXPECT_GT(map->size_bytes(), 0u);
  const auto most_within = [&](float side) {
    float most = 0;
    for (int i = 0; i < 1024; ++i)
      most = std::max(most, map->find({side * (static_cast<float>(i % 32) / 31 - 0.5f), 0,
                                       side * (static_cast<float>(i / 32) / 31 - 0.5f)})
                                .share);
    return most;
  };
  EXPECT_GT(most_within(0.6f), 0.3f);           // below the ball
  EXPECT_EQ(map->find({0, 9, 0}).share, 0.0f);  // outside
}

struct CausticSeeds {
  std::vector<test::Moments> regions;
  double noise = 0;  // mean square of what differs between two seeds
};

CausticSeeds render_caustics(const PreparedScene& scene, RenderSettings settings, uint64_t first) {
  constexpr uint64_t kSeeds = 16;
  CausticSeeds out{std::vector<test::Moments>(size_t{kCausticRegions * kCausticRegions})};
  Image before;
  for (uint64_t i = 0; i < kSeeds; ++i) {
    settings.seed = first + i;
    Image image = test::render(scene, settings).image;
    const std::vector<double> means = test::region_luminances(image, kCausticRegions);
    for (size_t r = 0; r < means.size(); ++r) out.regions[r].add(means[r]);
    for (size_t p = 0; i > 0 && p < image.data().size(); ++p) {
      const double d = double{image.data()[p]} - double{before.data()[p]};
      out.noise += d * d;
    }
    before = std::move(image);
  }
  return out;
}

TEST(CausticPaths, RegionsKeepTheirMeanAndLoseNoise) {
  const double level = test::significance(3 * 2 * kCausticRegions * kCausticRegions);
  for (const Focus focus : {Focus::kBall, Focus::kMirror, Focus::kBallOnMetal})
    for (const bool nee : {true, false}) {
      const auto scene = test::prepare(focused_light(focus));
      RenderSettings settings = test::small_settings("adaptive", 32, 64);
      settings.nee = nee;
      settings.max_depth = 6;
      settings.adaptive.caustics = false;
      const CausticSeeds plain = render_caustics(*scene, settings, 1);
      settings.adaptive.caustics = true;
      const CausticSeeds aimed = render_caustics(*scene, settings, 101);
      for (size_t i = 0; i < plain.regions.size(); ++i) {
        const test::Moments &a = aimed.regions[i], &b = plain.regions[i];
        EXPECT_GT(test::z_test(a, b).p_value, level)
            << "focus " << static_cast<int>(focus) << ", nee " << nee << ", region " << i << ": "
            << a.mean() << " +- " << a.standard_error() << ", without " << b.mean() << " +- "
            << b.standard_error();
      }
      if (nee) {
        EXPECT_LT(aimed.noise, 0.7 * plain.noise) << "focus " << static_cast<int>(focus);
      }
    }
}

}  // namespace
}  // namespace qray
