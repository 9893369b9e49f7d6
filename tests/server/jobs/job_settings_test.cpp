#include "server/jobs/job_settings.h"

#include <gtest/gtest.h>

namespace qray::server {
namespace {

TEST(JobSettings, TheSceneFillsWhatIsLeftOut) {
  Scene scene;
  scene.width = 48;
  scene.height = 40;
  scene.max_depth = 5;
  proto::JobRequest request;
  request.samples = 8;
  const RenderSettings s = settings_of(request, scene);
  EXPECT_EQ(s.width, 48);
  EXPECT_EQ(s.height, 40);
  EXPECT_EQ(s.max_depth, 5);
  EXPECT_EQ(s.samples, 8);
  EXPECT_EQ(s.seconds, 0);
  EXPECT_EQ(s.method, "adaptive");
  EXPECT_EQ(s.huang, HuangParams{});
  EXPECT_EQ(s.camera, std::nullopt);
}

TEST(JobSettings, DefaultsAreTheRenderersAndReadShort) {
  proto::JobRequest request;
  request.grid = 7;
  fill_defaults(request);
  EXPECT_EQ(request.grid, 7);
  ASSERT_TRUE(request.alpha && request.gamma && request.learning_samples);
  EXPECT_EQ(static_cast<float>(*request.alpha), HuangParams{}.alpha);
  EXPECT_EQ(static_cast<float>(*request.gamma), HuangParams{}.gamma);
  EXPECT_EQ(request.learning_samples, RenderSettings{}.learning_samples);
  EXPECT_EQ(proto::job_request_to_json(request).find("0.0200"), std::string::npos);
}

TEST(JobSettings, TheRequestGoesFirst) {
  Scene scene;
  scene.camera.position = {1, 2, 3};
  scene.camera.vertical_fov_deg = 33;
  proto::JobRequest request;
  request.width = 7;
  request.height = 9;
  request.max_depth = 2;
  request.seconds = 1.5;
  request.seed = 5;
  request.nee = false;
  request.alpha = 0.5;
  request.grid = 9;
  request.camera.emplace().target = {4, 5, 6};
  const RenderSettings s = settings_of(request, scene);
  EXPECT_EQ(s.width, 7);
  EXPECT_EQ(s.height, 9);
  EXPECT_EQ(s.max_depth, 2);
  EXPECT_EQ(s.samples, 0);  // no limit but the time
  EXPECT_EQ(s.seconds, 1.5);
  EXPECT_EQ(s.seed, 5u);
  EXPECT_FALSE(s.nee);
  EXPECT_EQ(s.huang.alpha, 0.5f);
  EXPECT_EQ(s.huang.grid, 9);
  ASSERT_TRUE(s.camera);
  EXPECT_EQ(s.camera->target, (Vec3{4, 5, 6}));
  EXPECT_EQ(s.camera->position, (Vec3{1, 2, 3}));
  EXPECT_EQ(s.camera->vertical_fov_deg, 33);
}

}  // namespace
}  // namespace qray::server
