#include "core/laboratory/screenshots.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/laboratory/views_file.h"
#include "tests/support/render.h"
#include "tests/support/scratch.h"

namespace qray {
namespace {

std::vector<TrainingView> views_of(const PreparedScene& scene, int count, int threads) {
  TaskPool pool(threads);
  ScreenshotOptions options;
  options.views = count;
  options.most_samples = 4;
  options.target_samples = 8;
  return take_screenshots(scene, test::small_settings("none", 64, 1), std::nullopt, options, pool,
                          {}, SteadyClock(), [](int) {})
      .value();
}

bool same(const Image& a, const Image& b) {
  return std::equal(a.data().begin(), a.data().end(), b.data().begin(), b.data().end());
}

TEST(Screenshots, CamerasStandInTheSceneAndNotAgainstItsWalls) {
  const auto scene = test::included_scene("thesis-room");
  const float diagonal = length(scene->bounds.extent());
  const std::vector<Camera> cameras = screenshot_cameras(*scene, 20, 512, 3);
  ASSERT_EQ(cameras.size(), 20u);
  for (const Camera& c : cameras) {
    for (int a = 0; a < 3; ++a) {
      EXPECT_GE(c.position[a], scene->bounds.lo[a]);
      EXPECT_LE(c.position[a], scene->bounds.hi[a]);
      Vec3 axis{};
      axis[a] = 1;
      Hit hit;
      if (scene->accel->intersect({c.position, axis}, hit)) {
        EXPECT_GT(hit.t, 0.015f * diagonal);
      }
    }
  }
}

TEST(Screenshots, InputsAndTargetsAreOtherRandomNumbersOfOneView) {
  const auto scene = test::included_scene("cornell-box");
  const std::vector<TrainingView> views = views_of(*scene, 3, 2);
  ASSERT_EQ(views.size(), 3u);
  for (const TrainingView& v : views) {
    EXPECT_EQ(v.input.colour.width(), kScreenshotSide);
    EXPECT_FALSE(same(v.input.colour, v.target));
    EXPECT_LT(relmse(v.input.colour, v.target), 100);
    EXPECT_GT(v.target_relmse, 0);
    EXPECT_LT(v.target_relmse, relmse(v.input.colour, v.target) + 1);
  }
  EXPECT_FALSE(same(views[0].input.features, views[1].input.features));
}

TEST(Screenshots, InputsOfAViewShareItsTargetAndHaveOtherSamples) {
  const auto scene = test::included_scene("cornell-box");
  TaskPool pool(2);
  ScreenshotOptions options;
  options.views = 2, options.inputs = 3;
  options.most_samples = 2, options.target_samples = 8;
  options.guided_targets = true;
  const std::vector<TrainingView> views =
      take_screenshots(*scene, test::small_settings("none", 64, 1), std::nullopt, options, pool, {},
                       SteadyClock(), [](int) {})
          .value();
  ASSERT_EQ(views.size(), 6u);
  for (size_t i = 0; i < 6; ++i) {
    const TrainingView &v = views[i], &first = views[i / 3 * 3];
    EXPECT_TRUE(same(v.target, first.target)) << i;
    EXPECT_TRUE(same(v.input.features, first.input.features)) << i;
    EXPECT_EQ(same(v.input.colour, first.input.colour), i % 3 == 0) << i;
    // 1 and 2 samples in turn: of one alone the pixel's own noise is not known.
    EXPECT_EQ(std::isinf(v.input.own_error.at(64, 64, 0)), i % 2 == 0) << i;
  }
  EXPECT_FALSE(same(views[0].target, views[3].target));
}

TEST(Screenshots, AreKeptInAFileForTheNextTraining) {
  const auto scene = test::included_scene("cornell-box");
  const std::vector<TrainingView> views = views_of(*scene, 2, 2);
  const test::ScratchFolder folder;
  const std::filesystem::path path = folder / "some.views";
  EXPECT_EQ(read_views(path).error().code, ErrorCode::kNotFound);
  ASSERT_TRUE(write_views(path, views).ok());
  const Result<std::vector<TrainingView>> read = read_views(path);
  ASSERT_TRUE(read.ok()) << read.error().text();
  ASSERT_EQ(read.value().size(), views.size());
  for (size_t i = 0; i < views.size(); ++i) {
    EXPECT_TRUE(same(read.value()[i].target, views[i].target));
    EXPECT_TRUE(same(read.value()[i].input.shown, views[i].input.shown));
    EXPECT_TRUE(same(read.value()[i].input.own_error, views[i].input.own_error));
    EXPECT_EQ(read.value()[i].target_relmse, views[i].target_relmse);
  }
  std::filesystem::resize_file(path, std::filesystem::file_size(path) - 1);
  EXPECT_EQ(read_views(path).error().code, ErrorCode::kCorrupt);
}

TEST(Screenshots, AreTheSameForAnyNumberOfThreads) {
  const auto scene = test::included_scene("cornell-box");
  const std::vector<TrainingView> one = views_of(*scene, 2, 1), three = views_of(*scene, 2, 3);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_TRUE(same(one[i].input.colour, three[i].input.colour));
    EXPECT_TRUE(same(one[i].input.noise, three[i].input.noise));
    EXPECT_TRUE(same(one[i].target, three[i].target));
  }
}

}  // namespace
}  // namespace qray
