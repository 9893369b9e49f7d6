#include "core/cmd/render_options.h"

#include <gtest/gtest.h>

#include "proto/messages.h"

namespace qray::cmd {
namespace {

TEST(RenderOptions, ReadsASize) {
  const auto size = parse_size("640x480");
  ASSERT_TRUE(size.ok());
  EXPECT_EQ(size.value(), (std::pair{640, 480}));
  for (const char* wrong :
       {"", "640", "640x", "x480", "640x480x2", "-1x5", "0x5", "64 x 48", "99999999999x1"})
    EXPECT_FALSE(parse_size(wrong).ok()) << wrong;
}

TEST(RenderOptions, TakesWhatIsNotGivenFromTheScene) {
  Scene scene;
  scene.width = 320;
  scene.height = 200;
  scene.max_depth = 9;
  RenderOptions options;
  const auto plain = make_settings(options, scene);
  ASSERT_TRUE(plain.ok());
  EXPECT_EQ(plain.value().width, 320);
  EXPECT_EQ(plain.value().height, 200);
  EXPECT_EQ(plain.value().max_depth, 9);
  EXPECT_EQ(plain.value().method, RenderSettings().method);
  EXPECT_EQ(plain.value().samples, RenderSettings().samples);
  EXPECT_TRUE(plain.value().nee);
}

TEST(RenderOptions, PassesOnWhatIsGiven) {
  RenderOptions options;
  options.method = "none:nee=off";
  options.size = "64x32";
  options.given.set(field::kSeconds, 2.5);
  options.given.set(field::kSeed, 77);
  options.given.set(field::kMaxDepth, 3);
  options.given.set("camera/target", Vector3{1, 2, 3});
  Scene scene;
  scene.camera.position = {7, 8, 9};
  const auto made = make_settings(options, scene);
  ASSERT_TRUE(made.ok());
  const RenderSettings& s = made.value();
  EXPECT_EQ(s.method, "none");
  EXPECT_FALSE(s.nee);
  EXPECT_EQ(s.seconds, 2.5);
  EXPECT_EQ(s.samples, 0);  // as many as fit
  EXPECT_EQ(s.seed, 77u);
  EXPECT_EQ(s.width, 64);
  EXPECT_EQ(s.height, 32);
  EXPECT_EQ(s.max_depth, 3);
  ASSERT_TRUE(s.camera);
  EXPECT_EQ(s.camera->position, (Vec3{7, 8, 9}));
  EXPECT_EQ(s.camera->target, (Vec3{1, 2, 3}));
  options.method = "huang:grid=12;alpha=.5;depth=9";
  const auto huang = make_settings(options, scene);
  ASSERT_TRUE(huang.ok());
  EXPECT_EQ(huang.value().huang.grid, 12);
  EXPECT_EQ(huang.value().huang.alpha, 0.5f);
  EXPECT_EQ(huang.value().max_depth, 3);  // the option goes first
  options.size = "64";
  EXPECT_FALSE(make_settings(options, scene).ok());
}

TEST(RenderOptions, LeaveTheRestToTheServer) {
  RenderOptions options;
  options.scene = "cornell-box";
  const auto plain = make_request(options, kSubmit);
  ASSERT_TRUE(plain.ok());
  EXPECT_EQ(proto::job_request_to_json(plain.value()), R"({"scene":"cornell-box"})");
  options.given.set(field::kNee, false);
  options.size = "8x4";
  options.method = "adaptive:split=100;gate=off";
  const auto given = make_request(options, kSubmit);
  ASSERT_TRUE(given.ok());
  EXPECT_EQ(proto::job_request_to_json(given.value()),
            R"({"scene":"cornell-box","width":8,"height":4,"method":"adaptive","nee":false,)"
            R"("gate":false,"guide":{"split":100.0}})");
  options.method = "adaptive:roulette=off";  // a chart's alone
  EXPECT_FALSE(make_request(options, kSubmit).ok());
  EXPECT_TRUE(make_request(options, kRender).ok());
}

}  // namespace
}  // namespace qray::cmd
