#include "core/cmd/render_options.h"

#include <gtest/gtest.h>

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
  options.method = "none";
  options.no_nee = true;
  options.seconds = 2.5;
  options.seed = 77;
  options.size = "64x32";
  options.max_depth = 3;
  options.grid = 12;
  options.alpha = 0.5f;
  const auto made = make_settings(options, Scene());
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
  EXPECT_EQ(s.huang.grid, 12);
  EXPECT_EQ(s.huang.alpha, 0.5f);
  options.size = "64";
  EXPECT_FALSE(make_settings(options, Scene()).ok());
}

TEST(RenderOptions, LeaveTheRestToTheServer) {
  RenderOptions options;
  options.scene = "cornell-box";
  const auto plain = make_submission(options);
  ASSERT_TRUE(plain.ok());
  EXPECT_EQ(plain.value().scene, "cornell-box");
  EXPECT_FALSE(plain.value().nee.has_value());
  EXPECT_FALSE(plain.value().samples.has_value());
  options.no_nee = true;
  options.size = "8x4";
  const auto given = make_submission(options);
  ASSERT_TRUE(given.ok());
  EXPECT_EQ(given.value().nee, false);
  EXPECT_EQ(given.value().width, 8);
  EXPECT_EQ(given.value().height, 4);
}

}  // namespace
}  // namespace qray::cmd
