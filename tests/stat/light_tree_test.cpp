// The tree over lights: it picks with the probabilities that it tells, misses no light that sends
// something, and pictures keep their mean by region, whatever picks the lights.
#include <gtest/gtest.h>

#include "core/math/warp.h"
#include "core/render/light_tree.h"
#include "tests/support/chi2.h"
#include "tests/support/render.h"
#include "tests/support/stats.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

Vec3 place(test::Random& random) {
  return {4 * random.next() - 2, 2 * random.next(), 4 * random.next() - 2};
}

struct Triangle {
  Vec3 p0, e1, e2, n;
  LightBounds bounds;
};

// Intensities over four decades, sizes over two; every third shines both ways.
std::vector<Triangle> triangles(size_t count, test::Random& random) {
  std::vector<Triangle> all(count);
  for (size_t i = 0; i < count; ++i) {
    Triangle& t = all[i];
    const float size = std::pow(10.0f, -2 * random.next());
    t.p0 = place(random);
    t.e1 = square_to_uniform_sphere(random.next_2d()) * size;
    t.e2 = square_to_uniform_sphere(random.next_2d()) * size;
    t.n = normalize(cross(t.e1, t.e2));
    for (const Vec3 p : {t.p0, t.p0 + t.e1, t.p0 + t.e2}) t.bounds.box.add(p);
    t.bounds.axis = t.n;
    t.bounds.intensity = std::pow(10.0f, 4 * random.next());
    t.bounds.two_sided = i % 3 == 0;
  }
  return all;
}

std::vector<LightBounds> bounds_of(const std::vector<Triangle>& all) {
  std::vector<LightBounds> bounds;
  for (const Triangle& t : all) bounds.push_back(t.bounds);
  return bounds;
}

// With points and spots among them, some at one place.
std::vector<LightBounds> lights_of_all_kinds(size_t count, test::Random& random) {
  std::vector<LightBounds> all = bounds_of(triangles(count, random));
  for (size_t i = 0; i < count / 4; ++i) {
    LightBounds b;
    b.box.add(i % 8 < 4 ? place(random) : Vec3{1, 1, 1});
    b.axis = square_to_uniform_sphere(random.next_2d());
    b.cos_spread = i % 2 ? -1 : 0.8f;
    b.cos_emission = 1;
    b.intensity = 100 * random.next();
    all.push_back(b);
  }
  return all;
}

LightReceiver receiver(test::Random& random, int i) {
  return {place(random), i % 3 == 0 ? Vec3{} : square_to_uniform_sphere(random.next_2d())};
}

TEST(LightTree, PicksFollowTheirProbabilities) {
  constexpr int kPicks = 100'000;
  constexpr int kReceivers = 4;
  const std::vector<size_t> counts{1, 8, 9, 40, 700};
  const double level = test::significance(static_cast<int>(counts.size()) * kReceivers);
  for (const size_t count : counts) {
    test::Random random(count);
    const std::vector<LightBounds> lights = lights_of_all_kinds(count, random);
    const LightTree tree(lights);
    for (int r = 0; r < kReceivers; ++r) {
      const LightReceiver at = receiver(random, r);
      // The last: none, since no light of the part of the tree that was taken reaches the point.
      std::vector<double> expected(lights.size() + 1), observed(lights.size() + 1);
      double sum = 0;
      for (uint32_t i = 0; i < lights.size(); ++i) {
        const double p = tree.probability(at, i);
        expected[i] = p * kPicks;
        sum += p;
      }
      EXPECT_LT(sum, 1 + 1e-5);
      expected.back() = std::max(0.0, 1 - sum) * kPicks;
      for (int i = 0; i < kPicks; ++i) {
        const LightTree::Pick pick = tree.sample(at, double{random.next()});
        if (pick.probability > 0) {
          ++observed[pick.light];
          ASSERT_NEAR(pick.probability / tree.probability(at, pick.light), 1, 1e-5);
        } else {
          ++observed.back();
        }
      }
      const test::Chi2 chi2 = test::chi2_counts(observed, expected);
      EXPECT_GT(chi2.p_value, level) << count << " lights, receiver " << r << "\n" << chi2.table;
    }
  }
}

// Lights that shine everywhere reach every place: no pick is lost.
TEST(LightTree, ProbabilitiesOfPointsSumToOne) {
  test::Random random(3);
  std::vector<LightBounds> lights(300);
  for (LightBounds& b : lights) {
    b.box.add(place(random));
    b.cos_spread = -1;
    b.cos_emission = 1;
    b.intensity = std::pow(10.0f, 4 * random.next());
  }
  const LightTree tree(lights);
  for (int r = 0; r < 20; ++r) {
    const LightReceiver at{place(random), {}};
    double sum = 0;
    for (uint32_t i = 0; i < lights.size(); ++i) sum += double{tree.probability(at, i)};
    EXPECT_NEAR(sum, 1, 1e-5);
  }
}

TEST(LightTree, NoLightThatSendsSomethingIsMissed) {
  test::Random random(9);
  const std::vector<Triangle> all = triangles(300, random);
  const LightTree tree(bounds_of(all));
  int sends = 0;
  for (int r = 0; r < 200; ++r) {
    const LightReceiver at = receiver(random, r);
    for (uint32_t i = 0; i < all.size(); ++i) {
      const Vec2 b = square_to_triangle(random.next_2d());
      const Vec3 to_light = all[i].p0 + all[i].e1 * b.x + all[i].e2 * b.y - at.p;
      const float cos_light = -dot(to_light, all[i].n);
      if (!(all[i].bounds.two_sided ? cos_light != 0 : cos_light > 0)) continue;
      if (length(at.n) > 0 && !(dot(to_light, at.n) > 0)) continue;
      ++sends;
      ASSERT_GT(tree.probability(at, i), 0) << r << ", " << i;
    }
  }
  EXPECT_GT(sends, 10'000);
}

// Forty panels of very different power along the walls, some shining both ways, with lamps and a
// sky that a window lets in; glass and metal stand among them.
Scene hall() {
  Scene scene = test::room();
  scene.meshes.pop_back();
  const auto side = scene.meshes.begin() + 3;  // of the room's box: now open to the sky
  scene.meshes.erase(side);
  test::Random random(5);
  for (int i = 0; i < 40; ++i) {
    const MaterialId light =
        test::add_material(scene, Rgb{0.0f}, Rgb{std::pow(10.0f, 3 * random.next())});
    scene.materials[light.value].emission_two_sided = i % 4 == 0;
    const float x = 1.6f * random.next() - 0.8f, z = 1.6f * random.next() - 0.8f;
    test::add_quad(scene, light, {x, 0.2f + 1.7f * random.next(), z}, {0.06f, 0, 0}, {0, 0, 0.06f});
  }
  Material& block = scene.materials[1];
  block.kind = MaterialKind::kDielectric;
  block.roughness.value = 0.3f;
  PunctualLight point, spot;
  point.position = {-0.6f, 1.7f, 0.3f};
  spot.kind = LightKind::kSpot;
  spot.position = {-0.5f, 0.3f, -0.2f};
  spot.direction = {0, 1, 0};
  PunctualLight sun;
  sun.kind = LightKind::kDirectional;
  sun.direction = normalize({-1.0f, -0.5f, 0});
  scene.lights = {point, sun, spot};
  scene.environment.radiance = Rgb{0.5f};
  return scene;
}

constexpr int kRegions = 4;  // of a side

std::vector<test::Moments> by_region(const PreparedScene& scene, const std::string& method,
                                     bool weighed, uint64_t first_seed) {
  constexpr int kSide = 32, kSeeds = 16;
  std::vector<test::Moments> regions(kRegions * kRegions);
  for (uint64_t seed = first_seed; seed < first_seed + kSeeds; ++seed) {
    RenderSettings settings = test::small_settings(method, kSide, 32, seed);
    settings.light_table = weighed;
    settings.max_depth = 5;
    const Image image = test::render(scene, settings).image;
    std::vector<double> sums(regions.size());
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x)
        sums[static_cast<size_t>(y * kRegions / kSide * kRegions + x * kRegions / kSide)] +=
            double{luminance(image.rgb(x, y))};
    for (size_t i = 0; i < sums.size(); ++i) regions[i].add(sums[i]);
  }
  return regions;
}

TEST(LightTree, RegionsKeepTheirMean) {
  const auto scene = test::prepare(hall());
  ASSERT_TRUE(scene->lights.has_tree());
  ASSERT_FALSE(scene->lights.uniform().has_tree());
  const std::vector<test::Moments> alike = by_region(*scene, "none", false, 1);
  const double level = test::significance(3 * kRegions * kRegions);
  for (const char* method : {"none", "ppg", "adaptive"}) {
    const std::vector<test::Moments> tree = by_region(*scene, method, true, 101);
    const std::vector<test::Moments> own_alike = by_region(*scene, method, false, 1);
    double variance = 0, variance_alike = 0;
    for (size_t i = 0; i < alike.size(); ++i) {
      EXPECT_GT(test::z_test(tree[i], alike[i]).p_value, level)
          << method << ", region " << i << ": " << tree[i].mean() << " +- "
          << tree[i].standard_error() << ", alike " << alike[i].mean() << " +- "
          << alike[i].standard_error();
      variance += tree[i].variance(), variance_alike += own_alike[i].variance();
    }
    EXPECT_LT(variance, variance_alike) << method;
  }
}

// One disk in triangles needs no tree; they do where they stand apart, or shine into different
// directions, or where a sky is picked beside them.
TEST(LightTree, LightsThatSendTheSameAreNoTree) {
  struct Panels {
    float apart;  // metres
    bool turned, sky;
  };
  for (const Panels& c : {Panels{0.02f, false, false}, Panels{0.4f, false, false},
                          Panels{0.02f, true, false}, Panels{0.02f, false, true}}) {
    Scene scene = test::room();
    const MaterialId light = test::add_material(scene, Rgb{0.0f}, Rgb{40.0f});
    for (Mesh& mesh : scene.meshes)
      if (scene.materials[mesh.material.value].emits()) mesh.material = MaterialId(0);
    for (int i = 0; i < 6; ++i) {
      const Vec3 at{-0.5f + c.apart * static_cast<float>(i % 3), 1.5f,
                    c.apart * static_cast<float>(i / 3)};
      const Vec3 down = c.turned && i == 5 ? Vec3{0, 0.02f, 0} : Vec3{0.02f, 0, 0};
      test::add_quad(scene, light, at, down, {0, 0, 0.02f});
    }
    if (c.sky) {
      scene.environment.radiance = Rgb{0.5f};
      PunctualLight sun;
      sun.kind = LightKind::kDirectional;
      scene.lights = {sun};
    }
    const bool tree = test::prepare(std::move(scene))->lights.has_tree();
    EXPECT_EQ(tree, c.apart > 0.1f || c.turned || c.sky) << c.apart << c.turned << c.sky;
  }
}

// Directions that hit a panel have the density with which the panel is drawn.
TEST(LightTree, TheDensityOfAHitIsThatOfTheDraw) {
  const auto scene = test::prepare(hall());
  test::Random random(4);
  int hits = 0;
  for (int i = 0; i < 20'000; ++i) {
    const LightReceiver at{{1.6f * random.next() - 0.8f, random.next(), 0.5f},
                           square_to_uniform_sphere(random.next_2d())};
    LightSample light;
    const float u_light = random.next();
    if (!scene->lights.sample(at, u_light, random.next_2d(), light)) continue;
    Hit hit;
    if (light.punctual || !scene->accel->intersect({at.p, light.wi}, hit)) continue;
    if (std::abs(hit.t / light.distance - 1) > 1e-4f) continue;
    ++hits;
    const float cos_light = std::abs(dot(normalize(hit.ng), light.wi));
    const float pdf_w = scene->lights.pdf_w_of_hit(at, hit, cos_light);
    ASSERT_NEAR(pdf_w / light.pdf_w, 1, 0.01) << i;
  }
  EXPECT_GT(hits, 5'000);
}

}  // namespace
}  // namespace qray
