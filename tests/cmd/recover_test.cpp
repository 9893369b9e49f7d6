// qray recover, and what render and the thesis' figures do with its networks.
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/image/image_io.h"
#include "core/image/metrics.h"
#include "tests/cmd/command.h"
#include "tests/support/scratch.h"

namespace qray::test {
namespace {

class RecoverCommand : public ::testing::Test {
 protected:
  std::string file(const std::string& name) const { return (scratch_ / name).string(); }
  Outcome train(std::vector<std::string> more) const {
    std::vector<std::string> arguments{
        "recover",    "train", "cornell-box",  "--views", "3",       "--held-out", "1",
        "--most-spp", "4",     "--target-spp", "4",       "--steps", "2",          "-q"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return qray_command(arguments);
  }
  Outcome render(const std::string& out, std::vector<std::string> more) const {
    std::vector<std::string> arguments{"render",           "cornell-box", "--size", "64x48",
                                       "--method",         "none",        "-q",     "--json",
                                       file("stats.json"), "-o",          file(out)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return qray_command(arguments);
  }
  Image picture(const std::string& name) const { return read_image(file(name)).value(); }
  nlohmann::json stats() const {
    std::ifstream in(file("stats.json"));
    return nlohmann::json::parse(in, nullptr, false);
  }
  ScratchFolder scratch_;
};

TEST_F(RecoverCommand, WhatIsTrainedServesARender) {
  const Outcome trained = train({"-o", file("w.qrw")});
  ASSERT_EQ(trained.code, cmd::kExitOk) << trained.err;
  for (const char* rung : {"untrained", "included", "mean", "trained"})
    EXPECT_NE(trained.out.find(rung), std::string::npos) << trained.out;
  const Outcome info = qray_command({"recover", "info", file("w.qrw")});
  ASSERT_EQ(info.code, cmd::kExitOk) << info.err;
  const std::string id = info.out.substr(info.out.find("id") + 11, 32);

  const Outcome done = render("a.exr", {"--spp", "2", "--pixels", "quarter", "--recover",
                                        file("w.qrw"), "--sampled-out", file("s.exr")});
  ASSERT_EQ(done.code, cmd::kExitOk) << done.err;
  EXPECT_EQ(stats()["recovery"], id);
  EXPECT_EQ(stats()["pixels"], "quarter");
  EXPECT_EQ(stats()["paths"], 2 * 32 * 24);
  const Image sampled = picture("s.exr"), recovered = picture("a.exr");
  int filled = 0;
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x)
      if (x % 2 || y % 2) {
        EXPECT_EQ(sampled.rgb(x, y), Rgb{});
        filled += luminance(recovered.rgb(x, y)) > 0;
      }
  EXPECT_GT(filled, 64 * 48 / 2);
  EXPECT_NE(done.err.find("recover"), std::string::npos) << "it says that this is no measurement";
}

TEST_F(RecoverCommand, TheDefaultNetworkIsBetterThanBilinear) {
  ASSERT_EQ(render("truth.exr", {"--spp", "512"}).code, cmd::kExitOk);
  const auto error = [&](const char* network) {
    const Outcome done =
        render("r.exr", {"--spp", "4", "--seed", "3", "--pixels", "quarter", "--recover", network});
    EXPECT_EQ(done.code, cmd::kExitOk) << done.err;
    EXPECT_EQ(stats()["recovery"], network);
    return relmse(picture("r.exr"), picture("truth.exr"));
  };
  // Lamps, which bilinear interpolation blurs worst, are kept apart from both.
  EXPECT_LT(error("default"), 0.7 * error("bilinear"));
}

TEST_F(RecoverCommand, AllPixelsGoOnGettingBetterWithSamples) {
  ASSERT_EQ(render("truth.exr", {"--spp", "2048"}).code, cmd::kExitOk);
  const auto error = [&](const char* spp, const std::string& name) {
    const Outcome done = render("r.exr", {"--spp", spp, "--seed", "3", "--recover", "default",
                                          "--sampled-out", file("s.exr")});
    EXPECT_EQ(done.code, cmd::kExitOk) << done.err;
    return relmse(picture(name), picture("truth.exr"));
  };
  EXPECT_LT(error("4", "r.exr"), 0.5 * error("4", "s.exr"));
  EXPECT_LT(error("128", "r.exr"), 0.25 * error("4", "r.exr"));
}

TEST_F(RecoverCommand, ComparesOnViewsOfItsOwn) {
  const Outcome done = qray_command({"recover", "compare", "cornell-box", "--views", "2",
                                     "--most-spp", "4", "--target-spp", "16", "-q"});
  ASSERT_EQ(done.code, cmd::kExitOk) << done.err;
  for (const char* name : {"bilinear", "untrained", "default", "bilateral"})
    EXPECT_NE(done.out.find(name), std::string::npos) << done.out;
}

TEST_F(RecoverCommand, SaysWhatItExpected) {
  const auto refused = [&](const Outcome& done, const char* says) {
    EXPECT_EQ(done.code, cmd::kExitBadInput);
    EXPECT_NE(done.err.find(says), std::string::npos) << done.err;
  };
  refused(qray_command({"recover", "train", "cornell-box", "--views", "3", "--held-out", "3", "-o",
                        file("w.qrw")}),
          "fewer views kept apart");
  refused(qray_command({"render", "cornell-box", "--size", "63x48", "--pixels", "quarter", "-o",
                        file("a.exr")}),
          "even");
  std::ofstream(file("no.qrw")) << "not weights, but a text";
  refused(render("a.exr", {"--recover", file("no.qrw")}), "no.qrw");
  refused(qray_command({"recover", "info", file("no.qrw")}), "QRAYRCV1");
}

TEST_F(RecoverCommand, DrawsTheThesisFirstFourFigures) {
  std::vector<Image> figures;
  for (const char* figure : {"1", "2", "3", "4"}) {
    const Outcome done =
        qray_command({"thesis", "--figure", figure, "--scene", "cornell-box", "--size", "32x24",
                      "-o", file(figure) + std::string(".exr")});
    ASSERT_EQ(done.code, cmd::kExitOk) << done.err;
    figures.push_back(picture(figure + std::string(".exr")));
  }
  for (int i : {0, 2})
    EXPECT_EQ(figures[static_cast<size_t>(i)].rgb(5, 4), Rgb{}) << "a pixel that is not sampled";
  EXPECT_EQ(figures[1].width(), 512) << "4 x 4 views of 128";
  EXPECT_GT(luminance(figures[3].rgb(5, 21)), 0);
}

}  // namespace
}  // namespace qray::test
