// Lights picked by what a place has learned: the densities are those of the draws, pictures keep
// their mean by region, and have less noise where lights are hidden.
#include <gtest/gtest.h>

#include "core/math/warp.h"
#include "core/render/light_tree.h"
#include "tests/support/chi2.h"
#include "tests/support/render.h"
#include "tests/support/stats.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

// A row of weights that differ by a factor of 100, with some clusters near to nothing.
std::vector<float> any_weights(LightClusters clusters, uint64_t seed) {
  LightImportance lights(clusters);
  test::Random random(seed);
  const uint32_t place = lights.place(clusters.bounds.center(), {});
  for (uint32_t cluster = 0; cluster < clusters.count(); ++cluster) {
    const float sends = cluster % 5 == 0 ? 0 : std::pow(10.0f, 2 * random.next() - 1);
    for (int i = 0; i < 40; ++i) lights.record(place, std::array{ClusterPick{cluster, 1}}, sends);
  }
  lights.end_pass();
  const float* row = lights.weights(place);
  return {row, row + clusters.count()};
}

Scene under(Rgb radiance) {
  Scene scene;
  const MaterialId gray = test::add_material(scene, Rgb{0.5f});
  test::add_quad(scene, gray, {-1, 0, -1}, {0, 0, 2}, {2, 0, 0});
  scene.environment.radiance = radiance;
  scene.environment.image = Image(64, 32, 3);
  test::Random random(3);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 64; ++x)
      scene.environment.image.set_rgb(x, y, Rgb{x == 40 && y == 9 ? 300 : random.next()});
  return scene;
}

TEST(LightImportanceSampling, CellsOfAnEnvironmentFollowTheDensity) {
  const auto scene = test::prepare(under(Rgb{2.0f}));
  const LightPick& lights = scene->lights;
  ASSERT_EQ(lights.clusters().groups.size(), 1u);
  const std::vector<float> weights = any_weights(lights.clusters(), 5);
  test::Chi2Options options;
  options.tolerance = 1e-5;
  int beside = 0;  // that rounding put into the cell beside
  const test::Chi2 result = test::chi2_sphere(
      [&](test::Random& random) -> std::optional<Vec3> {
        LightSample light;
        const float u_light = random.next();
        if (!lights.sample({{0, 2, 0}, {}}, u_light, random.next_2d(), light, weights.data()))
          return std::nullopt;
        EXPECT_EQ(light.picked().size(), 1u);
        const float pdf_w = lights.from_environment(light.wi, weights.data()).pdf_w;
        beside += std::abs(light.pdf_w / pdf_w - 1) > 2e-3f;
        return light.wi;
      },
      [&](Vec3 wi) { return lights.from_environment(wi, weights.data()).pdf_w; }, options);
  EXPECT_GT(result.p_value, test::significance(1)) << result.table;
  EXPECT_NEAR(result.integral, 1, 1e-3);
  EXPECT_LT(beside, 10) << "of " << options.samples;
}

// With nothing learned, cells are drawn as without them.
TEST(LightImportanceSampling, PlainWeightsChangeNoDensity) {
  const auto scene = test::prepare(under(Rgb{2.0f}));
  const LightPick& lights = scene->lights;
  test::Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 wi = square_to_uniform_sphere(random.next_2d());
    const float plain = lights.from_environment(wi).pdf_w;
    EXPECT_NEAR(lights.from_environment(wi, lights.plain_weights()).pdf_w, plain,
                1e-3f * plain + 1e-6f);
  }
}

// Panels of very different power, lamps, a sun and a sky.
Scene yard(int panels) {
  Scene scene = under(Rgb{0.5f});
  test::Random random(5);
  for (int i = 0; i < panels; ++i) {
    const MaterialId light =
        test::add_material(scene, Rgb{0.0f}, Rgb{std::pow(10.0f, 3 * random.next())});
    scene.materials[light.value].emission_two_sided = i % 4 == 0;
    const float x = 1.6f * random.next() - 0.8f, z = 1.6f * random.next() - 0.8f;
    test::add_quad(scene, light, {x, 0.2f + 1.7f * random.next(), z}, {0.06f, 0, 0}, {0, 0, 0.06f});
  }
  PunctualLight point;
  point.position = {-0.6f, 1.7f, 0.3f};
  PunctualLight sun;
  sun.kind = LightKind::kDirectional;
  sun.direction = normalize({-1.0f, -0.5f, 0});
  scene.lights = {point, sun};
  return scene;
}

// Whether lights are few or in a tree: each light is drawn as often as its pick says, and a
// direction that hits one has the density of its draw.
TEST(LightImportanceSampling, PicksFollowTheirDensities) {
  for (const int panels : {2, 40}) {
    const auto scene = test::prepare(yard(panels));
    const LightPick& lights = scene->lights;
    ASSERT_EQ(lights.has_tree(), panels == 40);
    const std::vector<float> weights = any_weights(lights.clusters(), 9);
    test::Random random(4);
    int hits = 0;
    constexpr int kDraws = 60'000;
    for (int i = 0; i < kDraws; ++i) {
      const LightReceiver at{{0.1f, 0.9f, 0.5f}, {}};
      LightSample light;
      const float u_light = random.next();
      if (!lights.sample(at, u_light, random.next_2d(), light, weights.data())) continue;
      Hit hit;
      if (light.punctual || !scene->accel->intersect({at.p, light.wi}, hit)) continue;
      if (std::abs(hit.t / light.distance - 1) > 1e-4f) continue;
      ++hits;
      const float cos_light = std::abs(dot(normalize(hit.ng), light.wi));
      ASSERT_NEAR(lights.pdf_w_of_hit(at, hit, cos_light, weights.data()) / light.pdf_w, 1, 0.01);
    }
    EXPECT_GT(hits, 300) << panels;
  }
}

TEST(LightImportanceSampling, ATreesPicksFollowTheirProbabilities) {
  constexpr int kPicks = 200'000;
  test::Random random(11);
  std::vector<LightBounds> all(300);
  for (LightBounds& b : all) {
    b.box.add({4 * random.next() - 2, 2 * random.next(), 4 * random.next() - 2});
    b.cos_spread = -1;
    b.cos_emission = 1;
    b.intensity = std::pow(10.0f, 3 * random.next());
  }
  const LightTree tree(all);
  LightClusters clusters;
  clusters.bounds = {{-2, 0, -2}, {2, 2, 2}};
  for (const uint32_t count : tree.clusters()) clusters.groups.push_back({{}, count});
  ASSERT_GT(clusters.groups.size(), 4u);
  const std::vector<float> factors = any_weights(clusters, 13);
  const LightReceiver at{{0.3f, 0.4f, 0.1f}, {0, 1, 0}};
  std::vector<double> expected(all.size() + 1), observed(all.size() + 1);
  double sum = 0;
  for (uint32_t i = 0; i < all.size(); ++i) {
    expected[i] = double{tree.probability(at, i, factors.data())} * kPicks;
    sum += expected[i];
  }
  expected.back() = std::max(0.0, kPicks - sum);
  for (int i = 0; i < kPicks; ++i) {
    LightTree::Search search{.at = at, .u = double{random.next()}, .factors = factors.data()};
    tree.run({&search, 1}, 1);
    EXPECT_GE(search.passed_count, 1u);
    ++observed[search.pick.probability > 0 ? search.pick.light : all.size()];
  }
  const test::Chi2 chi2 = test::chi2_counts(observed, expected);
  EXPECT_GT(chi2.p_value, test::significance(1)) << chi2.table;
}

// Half of the room's lamps are in a closet that nothing else can see into.
Scene room_beside_a_closet() {
  Scene scene = test::room();
  scene.meshes.pop_back();
  const MaterialId white(0);
  test::add_box(scene, white, {-0.95f, 0.02f, -0.95f}, {-0.3f, 1.9f, -0.3f}, false);
  test::add_box(scene, white, {-0.95f, 0.02f, -0.95f}, {-0.3f, 1.9f, -0.3f}, true);
  test::Random random(5);
  for (int i = 0; i < 24; ++i) {
    const MaterialId light = test::add_material(scene, Rgb{0.0f}, Rgb{i % 2 ? 40.0f : 20.0f});
    const bool closed = i % 2;
    const float x = closed ? -0.9f + 0.5f * random.next() : -0.2f + random.next(),
                z = closed ? -0.9f + 0.5f * random.next() : -0.2f + random.next();
    test::add_quad(scene, light, {x, 0.3f + 1.5f * random.next(), z}, {0.06f, 0, 0}, {0, 0, 0.06f});
  }
  return scene;
}

constexpr int kLightRegions = 4;  // of a side

struct Seeds {
  std::vector<test::Moments> regions = std::vector<test::Moments>(kLightRegions * kLightRegions);
  double noise = 0;  // the mean distance of a pixel's luminance from that of the seed before
};

Seeds render_seeds(const PreparedScene& scene, const RenderSettings& like, uint64_t first_seed) {
  constexpr uint64_t kSeeds = 24;
  Seeds out;
  Image before;
  for (uint64_t seed = first_seed; seed < first_seed + kSeeds; ++seed) {
    RenderSettings settings = like;
    settings.seed = seed;
    Image image = test::render(scene, settings).image;
    const std::vector<double> means = test::region_luminances(image, kLightRegions);
    for (size_t i = 0; i < means.size(); ++i) out.regions[i].add(means[i]);
    if (!before.empty())
      for (size_t i = 0; i < image.data().size(); ++i)
        out.noise += std::abs(double{image.data()[i]} - double{before.data()[i]});
    before = std::move(image);
  }
  return out;
}

TEST(LightImportanceSampling, RegionsKeepTheirMeanAndLoseNoise) {
  const auto scene = test::prepare(room_beside_a_closet());
  ASSERT_TRUE(scene->lights.has_tree());
  const double level = test::significance(2 * 2 * kLightRegions * kLightRegions);
  for (const bool nee : {true, false}) {
    RenderSettings settings = test::small_settings("none", 32, 32);
    settings.nee = nee;
    settings.max_depth = 5;
    const Seeds plain = render_seeds(*scene, settings, 1);
    settings.method = "adaptive";
    settings.gate = false;
    const Seeds learned = render_seeds(*scene, settings, 101);
    settings.adaptive.lights = false;
    const Seeds unlearned = render_seeds(*scene, settings, 201);
    for (size_t i = 0; i < plain.regions.size(); ++i)
      for (const Seeds* other : {&learned, &unlearned}) {
        const test::Moments &a = other->regions[i], &b = plain.regions[i];
        EXPECT_GT(test::z_test(a, b).p_value, level)
            << "nee " << nee << ", region " << i << ": " << a.mean() << " +- " << a.standard_error()
            << ", none " << b.mean() << " +- " << b.standard_error();
      }
    if (nee) {
      EXPECT_LT(learned.noise, 0.95 * unlearned.noise) << "of none: " << plain.noise;
    }
  }
}

}  // namespace
}  // namespace qray
