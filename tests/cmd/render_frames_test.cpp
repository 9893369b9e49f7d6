// qray render of many frames: into folders and files that play.
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/image/animation.h"
#include "core/image/image_io.h"
#include "core/image/picture_layers.h"
#include "tests/cmd/command.h"
#include "tests/core/import/gltf_text.h"
#include "tests/support/render.h"
#include "tests/support/scratch.h"

namespace qray::test {
namespace {

class RenderFramesCommand : public ::testing::Test {
 protected:
  std::string file(const char* name) const { return (scratch_ / name).string(); }
  Outcome render(std::vector<std::string> more) const {
    std::vector<std::string> arguments{"render", "cornell-box", "--size", "24x16",
                                       "-q",     "--spp",       "2"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return qray_command(arguments);
  }
  ScratchFolder scratch_;
};

TEST_F(RenderFramesCommand, ATurntableFillsAFolder) {
  const Outcome done =
      render({"--turntable", "3", "--turntable-degrees", "20", "--json", file("stats.json"),
              "--table-out", file("t.qrt"), "-o", file("out/")});
  ASSERT_EQ(done.code, cmd::kExitOk) << done.err;
  for (const char* name : {"out/frame-0000.png", "out/frame-0001.png", "out/frame-0002.png"})
    EXPECT_TRUE(read_image(file(name)).ok()) << name;
  EXPECT_EQ(read_image_metadata(file("out/frame-0002.png")).value()["frame"], "2");
  std::ifstream in(file("stats.json"));
  const nlohmann::json stats = nlohmann::json::parse(in, nullptr, false);
  EXPECT_EQ(stats["job"]["frames"], 3);
  ASSERT_EQ(stats["frames"].size(), 3u);
  EXPECT_EQ(stats["frames"][1]["samples"], 2);
  EXPECT_EQ(qray_command({"table", "info", file("t.qrt")}).code, cmd::kExitOk);
}

TEST_F(RenderFramesCommand, CamerasComeByJsonAndFromAFile) {
  const char* camera = R"({"position":[0,1,3],"target":[0,1,0]})";
  Outcome done = render({"--camera", camera, "--camera", R"({"vertical_fov_deg":20})",
                         "--frame-format", "exr", "-o", file("two")});
  ASSERT_EQ(done.code, cmd::kExitOk) << done.err;
  EXPECT_TRUE(read_image(file("two/frame-0001.exr")).ok());
  done = render({"--camera", camera, "-o", file("one.exr")});  // one: a picture
  ASSERT_EQ(done.code, cmd::kExitOk) << done.err;
  std::ofstream(file("frames.json")) << R"({"turntable":2,"degrees":10})";
  done = render({"--frames", file("frames.json"), "-o", file("turn.gif")});
  ASSERT_EQ(done.code, cmd::kExitOk) << done.err;
  EXPECT_TRUE(read_image(file("turn.gif")).ok());
}

TEST_F(RenderFramesCommand, AnAnimationIsAsTheFileMoves) {
  GltfText text = gltf_triangle();
  text.json["nodes"][0]["scale"] = {2, 2, 1};
  text.animate(0, "translation", {0, 2}, {0, 0, 0, 3, 0, 0}, "VEC3");
  std::ofstream(file("a.gltf")) << text.gltf();
  const auto animate = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"render", file("a.gltf"),   "--size", "24x16",
                                       "-q",     "--spp",          "2",      "--method",
                                       "none",   "--animation",    "1",      "--frame-seeds",
                                       "one",    "--frame-format", "exr"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return qray_command(arguments);
  };
  Outcome done = animate({"-o", file("all")});
  ASSERT_EQ(done.code, cmd::kExitOk) << done.err;
  EXPECT_FALSE(std::filesystem::exists(file("all/frame-0003.exr")));
  // One moment is a picture.
  done = animate({"--animation-from", "1", "--animation-to", "1", "-o", file("one.exr")});
  ASSERT_EQ(done.code, cmd::kExitOk) << done.err;
  const Image one = read_image(file("one.exr")).value();
  EXPECT_TRUE(same_bits(one, read_image(file("all/frame-0001.exr")).value()));
  EXPECT_FALSE(same_bits(one, read_image(file("all/frame-0000.exr")).value()));
  done = qray_command({"scene", "check", file("a.gltf")});
  EXPECT_NE(done.out.find("moves for 2 s"), std::string::npos) << done.out;
}

TEST_F(RenderFramesCommand, PassesGoIntoAFolderOfTheirOwn) {
  const Outcome done = render({"--turntable", "2", "--turntable-degrees", "10", "--passes",
                               "motion,depth", "--passes-out", file("layers"), "-o", file("out")});
  ASSERT_EQ(done.code, cmd::kExitOk) << done.err;
  const Result<PictureLayer> motion = read_layer(file("layers/frame-0000.exr"), "forward");
  ASSERT_TRUE(motion.ok()) << motion.error().text();
  EXPECT_NE(motion.value().image.at(12, 12, 0), 0);
}

TEST_F(RenderFramesCommand, WhatCannotBeIsRefused) {
  std::ofstream(file("bad.json")) << R"({"turntable":"many"})";
  for (const std::vector<std::string>& wrong : {
           std::vector<std::string>{"--turntable", "2", "-o", file("a.png")},
           {"--turntable", "2", "--camera", "front", "-o", file("a")},
           {"--turntable", "2", "--replay", "1", "-o", file("a")},
           {"--turntable", "2", "--view", "albedo", "-o", file("a")},
           {"--turntable", "2", "--exposure", "auto", "-o", file("a")},
           {"--turntable-degrees", "20", "-o", file("a")},
           {"--animation", "24", "-o", file("a")},  // the scene stands
           {"--camera", "front", "-o", file("a")},  // the scene names none
           {"--camera", "{\"fov\":2}", "-o", file("a")},
           {"--frames", file("bad.json"), "-o", file("a")},
       })
    EXPECT_NE(render(wrong).code, cmd::kExitOk) << wrong[0] << " " << wrong[1];
  if (!has_ffmpeg()) {
    EXPECT_NE(render({"--turntable", "2", "-o", file("a.mp4")}).code, cmd::kExitOk);
  }
}

}  // namespace
}  // namespace qray::test
