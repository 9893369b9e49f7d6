#include "core/job/picture_passes.h"

#include <gtest/gtest.h>

#include "core/render/light_split.h"
#include "tests/support/render.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

struct Outcome {
  std::unique_ptr<Film> film;
  JobResult job;
  const Image& layer(const std::string& name) const {
    for (const PictureLayer& one : job.passes->layers)
      if (one.name == name) return one.image;
    ADD_FAILURE() << "no layer " << name;
    return job.passes->layers.front().image;
  }
};

Outcome run(const PreparedScene& scene, const RenderSettings& settings, int threads = 2) {
  Outcome out;
  out.film =
      std::make_unique<Film>(settings.width, settings.height, film_layers(scene.scene, settings));
  TaskPool pool(threads);
  RenderObserver observer;
  Result<JobResult> job =
      run_job(scene, settings, {}, *out.film, pool, observer, {}, SteadyClock());
  EXPECT_TRUE(job.ok()) << job.error().text();
  out.job = std::move(job).value();
  return out;
}

// Four lights of all kinds: two panels, a lamp without extent, a sky seen through a gap.
Scene lit_room() {
  Scene scene = test::room();
  const MaterialId blue = test::add_material(scene, Rgb{0.2f}, {0.5f, 1, 6});
  const MaterialId pane = test::add_material(scene, Rgb{0.0f});
  scene.materials[pane.value].kind = MaterialKind::kThinDielectric;
  test::add_quad(scene, pane, {-0.7f, 0.1f, -0.4f}, {0, 0.8f, 0}, {0, 0, 0.8f});
  test::add_quad(scene, blue, {-0.95f, 0.2f, -0.5f}, {0, 0.5f, 0}, {0, 0, 0.5f});
  scene.materials[2].light_group = "ceiling";
  scene.materials[3].light_group = "wall";
  PunctualLight spot;
  spot.kind = LightKind::kSpot;
  spot.position = {0.5f, 1.9f, 0.5f};
  spot.direction = {0, -1, 0};
  spot.intensity = {2, 1, 0.5f};
  spot.light_group = "spot";
  scene.lights.push_back(spot);
  scene.meshes.erase(scene.meshes.begin() + 5);  // a side of the room
  scene.environment.radiance = {0.5f, 0.6f, 0.8f};
  return scene;
}

RenderSettings small(const std::string& method) {
  RenderSettings settings = test::small_settings(method, 48, 16);
  settings.height = 70;  // two tiles
  return settings;
}

float relative(float a, float b) { return std::abs(a - b) / std::max(std::abs(b), 1e-3f); }

TEST(PicturePasses, EmissionDirectAndIndirectAreTheBeautyWhichTheyDoNotChange) {
  const auto scene = test::prepare(lit_room());
  for (const char* method : {"none", "adaptive", "ppg"}) {
    RenderSettings settings = small(method);
    const Outcome plain = run(*scene, settings);
    for (const char* name : {"direct", "indirect", "emission"}) settings.picture_passes.add(name);
    const Outcome split = run(*scene, settings);
    EXPECT_FALSE(plain.job.passes.has_value());
    EXPECT_TRUE(test::same_bits(plain.film->develop(), split.film->develop())) << method;
    const Image beauty = split.film->develop();
    EXPECT_TRUE(test::same_bits(split.layer(""), beauty));
    const Image &direct = split.layer("direct"), &indirect = split.layer("indirect"),
                &emission = split.layer("emission");
    for (const Image* part : {&direct, &indirect, &emission})
      EXPECT_GT(test::mean_luminance(*part), 0) << method;
    for (size_t i = 0; i < beauty.data().size(); ++i)
      ASSERT_LT(
          relative(direct.data()[i] + indirect.data()[i] + emission.data()[i], beauty.data()[i]),
          1e-5f)
          << method;
  }
}

// With the same random numbers, paths of two surfaces are what paths of many begin with. When their
// rays to lights are traced, and thus the order in which a pixel's light is summed, may differ.
TEST(PicturePasses, DirectIsWhatPathsOfTwoSurfacesBring) {
  const auto scene = test::prepare(lit_room());
  RenderSettings settings = small("none");
  settings.picture_passes.add("direct");
  settings.picture_passes.add("emission");
  const Outcome whole = run(*scene, settings);
  settings.max_depth = 2;
  const Outcome two = run(*scene, settings);
  const Image &of_whole = whole.layer("direct"), &of_two = two.layer("direct");
  for (size_t i = 0; i < of_two.data().size(); ++i)
    ASSERT_LT(relative(of_whole.data()[i], of_two.data()[i]), 1e-6f);
  EXPECT_TRUE(test::same_bits(whole.layer("emission"), two.layer("emission")));
  EXPECT_GT(test::mean_luminance(whole.film->develop()),
            1.05 * test::mean_luminance(two.film->develop()));
}

// The same for each number of bounces: paths of one surface more, less what those bring.
TEST(PicturePasses, ABounceIsWhatOneSurfaceMoreBrings) {
  const auto scene = test::prepare(lit_room());
  RenderSettings settings = small("none");
  settings.max_depth = 12;
  settings.picture_passes.add("bounces");
  settings.picture_passes.add("indirect");
  const Outcome whole = run(*scene, settings);
  settings.picture_passes = {};
  const auto up_to = [&](int surfaces) {
    settings.max_depth = surfaces;
    return run(*scene, settings).film->develop();
  };
  Image before = up_to(1);
  Image sum(before.width(), before.height(), 3);
  for (int bounce = 1; bounce <= kMostBounces; ++bounce) {
    const Image with = up_to(bounce < kMostBounces ? bounce + 1 : 12);
    const Image& layer = whole.layer("bounce" + std::to_string(bounce));
    EXPECT_GT(test::mean_luminance(layer), 0) << bounce;
    for (size_t i = 0; i < with.data().size(); ++i) {
      ASSERT_NEAR(layer.data()[i], with.data()[i] - before.data()[i],
                  1e-5f + with.data()[i] * 1e-5f)
          << bounce;
      if (bounce > 1) sum.data()[i] += layer.data()[i];
    }
    before = with;
  }
  for (size_t i = 0; i < sum.data().size(); ++i)
    ASSERT_LT(relative(sum.data()[i], whole.layer("indirect").data()[i]), 1e-4f);
}

// Each number's mean is the same with a guide, whose roulette pays what the table expects.
TEST(PicturePasses, AGuideKeepsTheMeanOfEachBounce) {
  const auto scene = test::prepare(lit_room());
  RenderSettings settings = small("none");
  settings.samples = 256;
  settings.picture_passes.add("bounces");
  const Outcome plain = run(*scene, settings);
  settings.method = "adaptive";
  const Outcome guided = run(*scene, settings);
  for (int bounce = 1; bounce <= 5; ++bounce) {
    const std::string name = "bounce" + std::to_string(bounce);
    EXPECT_NEAR(test::mean_luminance(guided.layer(name)) / test::mean_luminance(plain.layer(name)),
                1, 0.02)
        << name;
  }
}

TEST(PicturePasses, GroupsOfLightsSumToTheBeautyToTheBit) {
  const auto scene = test::prepare(lit_room());
  for (const char* method : {"none", "adaptive"})
    for (const bool nee : {true, false}) {
      RenderSettings settings = small(method);
      settings.nee = nee;
      settings.light_groups = LightGrouping::kScene;
      const Outcome one = run(*scene, settings, 1), many = run(*scene, settings, 3);
      const Image beauty = many.film->develop();
      EXPECT_TRUE(test::same_bits(one.film->develop(), beauty)) << method;
      Image sum(beauty.width(), beauty.height(), 3);
      std::vector<std::string> names;
      for (const PictureLayer& layer : many.job.passes->layers) {
        if (!layer.name.starts_with("Combined_")) continue;
        names.push_back(layer.name);
        EXPECT_GT(test::mean_luminance(layer.image), 0) << layer.name;
        for (size_t i = 0; i < sum.data().size(); ++i) {
          ASSERT_GE(layer.image.data()[i], 0) << layer.name;
          sum.data()[i] += layer.image.data()[i];
        }
      }
      EXPECT_EQ(names, (std::vector<std::string>{"Combined_ceiling", "Combined_wall",
                                                 "Combined_spot", "Combined_rest"}));
      EXPECT_TRUE(test::same_bits(sum, beauty)) << method << " nee " << nee;
    }
}

// In the mean over the picture, whose noise is below a hundredth here.
TEST(PicturePasses, AGroupIsTheLightOfItsLamps) {
  const Scene room = lit_room();
  RenderSettings settings = small("none");
  settings.samples = 64;
  settings.light_groups = LightGrouping::kScene;
  const Outcome mixed = run(*test::prepare(room), settings);
  Scene alone = room;
  alone.lights.clear();
  alone.environment.radiance = {};
  alone.materials[2].emission = {};
  settings.light_groups = LightGrouping::kNone;
  settings.samples = 256;
  const Outcome wall = run(*test::prepare(alone), settings);
  const double of_group = test::mean_luminance(mixed.layer("Combined_wall"));
  const double of_alone = test::mean_luminance(wall.film->develop());
  EXPECT_NEAR(of_group / of_alone, 1, 0.03);
}

TEST(PicturePasses, GroupsAreNamedByWhatIsAskedFor) {
  Scene scene = lit_room();
  scene.meshes.back().name = "tube";
  const auto groups = [&](LightGrouping by) {
    RenderSettings settings;
    settings.light_groups = by;
    return light_split(scene, settings).value().groups;
  };
  EXPECT_EQ(groups(LightGrouping::kMaterial),
            (std::vector<std::string>{"m2", "m3", "light 0", "environment"}));
  EXPECT_EQ(groups(LightGrouping::kName).at(1), "tube");
  EXPECT_EQ(groups(LightGrouping::kEach).size(), 4u);
  for (int i = 0; i < 61; ++i)
    test::add_quad(scene, MaterialId(3), {0, 0.1f, 0}, {0.01f, 0, 0}, {0, 0, 0.01f});
  RenderSettings settings;
  settings.light_groups = LightGrouping::kEach;
  EXPECT_EQ(light_split(scene, settings).error().where, "/light_groups");
}

TEST(PicturePasses, SamplesAndVarianceAreTheNoisesOwn) {
  const auto scene = test::prepare(test::room());
  RenderSettings settings = small("none");
  for (const char* name : {"samples", "variance"}) settings.picture_passes.add(name);
  const Outcome out = run(*scene, settings);
  const Image &samples = out.layer("samples"), &variance = out.layer("variance");
  EXPECT_EQ(samples.at(3, 3, 0), 16);
  EXPECT_EQ(samples.at(40, 69, 0), 16);
  double sum = 0;
  for (const float v : variance.data()) sum += v;
  EXPECT_GT(sum, 0);
}

TEST(PicturePasses, NamesOfGroupsBecomeNamesOfLayers) {
  EXPECT_EQ(light_group_layer("Desk lamp.2"), "Combined_Desk_lamp_2");
}

}  // namespace
}  // namespace qray
