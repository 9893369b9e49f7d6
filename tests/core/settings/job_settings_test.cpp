#include "core/settings/job_settings.h"

#include <gtest/gtest.h>

namespace qray {
namespace {

TEST(JobSettings, TheSceneFillsWhatIsLeftOut) {
  Scene scene;
  scene.width = 48;
  scene.height = 40;
  scene.max_depth = 5;
  JobRequest request;
  request.set(field::kSamples, 8);
  const RenderSettings s = settings_of(request, scene);
  EXPECT_EQ(s.width, 48);
  EXPECT_EQ(s.height, 40);
  EXPECT_EQ(s.max_depth, 5);
  EXPECT_EQ(s.samples, 8);
  EXPECT_EQ(s.seconds, 0);
  EXPECT_EQ(s.method, "adaptive");
  EXPECT_EQ(s.huang, HuangParams{});
  EXPECT_EQ(s.adaptive, AdaptiveParams{});
  EXPECT_EQ(s.camera, std::nullopt);
}

TEST(JobSettings, DefaultsAreTheRenderersAndOfTheMethodAlone) {
  JobRequest request;
  request.set(field::kMethod, "huang");
  request.set("guide/grid", int64_t{7});
  fill_defaults(request);
  EXPECT_EQ(*request.find("guide/grid"), FieldValue(int64_t{7}));
  EXPECT_EQ(*request.find("guide/alpha"), FieldValue(0.02));  // not 0.0199999995
  EXPECT_EQ(*request.find("guide/gamma"), FieldValue(0.2));
  EXPECT_EQ(*request.find("learning_samples"), FieldValue(int64_t{kMaxSamples}));
  EXPECT_EQ(request.find("guide/split"), nullptr);
  EXPECT_EQ(request.find("width"), nullptr);
  JobRequest none;
  none.set(field::kMethod, "none");
  fill_defaults(none);
  for (const auto& [path, value] : none.values()) EXPECT_FALSE(path.starts_with("guide/")) << path;
}

TEST(JobSettings, AJobWithItsDefaultsIsTheJobWithoutThem) {
  for (const Choice& method : find_field(job_fields(), "method")->choices) {
    JobRequest request;
    request.set(field::kMethod, method.value);
    request.set(field::kSamples, 3);
    JobRequest filled = request;
    fill_defaults(filled);
    const RenderSettings a = settings_of(request, Scene()), b = settings_of(filled, Scene());
    for (const Field& field : job_fields()) {
      if (!field.setting.read) continue;
      EXPECT_EQ(field.setting.read(a), field.setting.read(b)) << field.path;
    }
    EXPECT_EQ(a.huang, b.huang);
    EXPECT_EQ(a.adaptive, b.adaptive);
  }
}

TEST(JobSettings, TheRequestGoesFirst) {
  Scene scene;
  scene.camera.position = {1, 2, 3};
  scene.camera.vertical_fov_deg = 33;
  JobRequest request;
  request.set(field::kWidth, 7);
  request.set(field::kHeight, 9);
  request.set(field::kMaxDepth, 2);
  request.set(field::kSeconds, 1.5);
  request.set(field::kSeed, 5);
  request.set(field::kNee, false);
  request.set("gate", false);
  request.set("guide/alpha", 0.5);
  request.set("guide/grid", int64_t{9});
  request.set("camera/target", Vector3{4, 5, 6});
  const RenderSettings s = settings_of(request, scene);
  EXPECT_EQ(s.width, 7);
  EXPECT_EQ(s.height, 9);
  EXPECT_EQ(s.max_depth, 2);
  EXPECT_EQ(s.samples, 0);  // no limit but the time
  EXPECT_EQ(s.seconds, 1.5);
  EXPECT_EQ(s.seed, 5u);
  EXPECT_FALSE(s.nee);
  EXPECT_FALSE(s.gate);
  EXPECT_EQ(s.huang.alpha, 0.5f);
  EXPECT_EQ(s.huang.grid, 9);
  ASSERT_TRUE(s.camera);
  EXPECT_EQ(s.camera->target, (Vec3{4, 5, 6}));
  EXPECT_EQ(s.camera->position, (Vec3{1, 2, 3}));
  EXPECT_EQ(s.camera->vertical_fov_deg, 33);
}

TEST(JobSettings, ABudgetIsAlwaysThere) {
  const auto completed = [](JobRequest request) {
    complete_budget(request, 100);
    return std::pair(request.given(field::kSamples), request.given(field::kSeconds));
  };
  JobRequest request;
  EXPECT_EQ(completed(request), std::pair(std::optional(64), std::optional<double>()));
  request.set(field::kNoise, 0.1);
  EXPECT_EQ(completed(request), std::pair(std::optional<int>(), std::optional(100.0)));
  request.set(field::kSamples, 7);
  EXPECT_EQ(completed(request), std::pair(std::optional(7), std::optional<double>()));
}

}  // namespace
}  // namespace qray
