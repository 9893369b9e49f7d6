#include "core/cmd/render_view.h"

#include "core/image/false_color.h"
#include "core/image/image_io.h"
#include "core/render/lobe_view.h"
#include "tests/cmd/command.h"
#include "tests/support/scratch.h"

namespace qray::test {
namespace {

class RenderViewCommand : public ::testing::Test {
 protected:
  std::string file(const std::string& name) const { return (scratch_ / name).string(); }
  Outcome render(std::vector<std::string> more) const {
    std::vector<std::string> arguments{"render", "cornell-box", "--size", "24x16", "-q"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return qray_command(arguments);
  }
  // A table of the method, in a file of its name.
  std::string table(const std::string& method, const char* learning_samples = "16") const {
    const Outcome done =
        render({"--method", method, "--spp", "64", "--learning-samples", learning_samples,
                "--table-out", file(method + ".qrt"), "-o", file("a.exr")});
    EXPECT_EQ(done.code, cmd::kExitOk) << done.err;
    return file(method + ".qrt");
  }
  Image view(const std::string& name, const std::string& table,
             std::vector<std::string> more = {}) {
    const std::string out = file(name + ".exr");
    std::vector<std::string> arguments{"--view", name, "-o", out};
    if (!table.empty()) arguments.insert(arguments.end(), {"--table-in", table});
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome done = render(arguments);
    EXPECT_EQ(done.code, cmd::kExitOk) << name << ": " << done.err;
    const auto image = read_image(out);
    EXPECT_TRUE(image.ok()) << out;
    EXPECT_EQ(read_image_metadata(out).value().at("view"), name);
    return image.ok() ? image.value() : Image(1, 1, 3);
  }
  static bool same(const Image& a, const Image& b) {
    return std::equal(a.data().begin(), a.data().end(), b.data().begin(), b.data().end());
  }
  ScratchFolder scratch_;
};

TEST_F(RenderViewCommand, ShowsATableOfEveryMethod) {
  for (const char* method : {"huang", "dahm-keller", "ppg", "adaptive"}) {
    const std::string learned = table(method);
    std::vector<Image> views;
    for (const char* name : {"state", "beta", "gain"}) {
      views.push_back(view(name, learned));
      EXPECT_EQ(views.back().width(), 24);
      EXPECT_EQ(views.back().height(), 16);
    }
    EXPECT_FALSE(same(views[0], views[1])) << method;
    EXPECT_FALSE(same(views[1], views[2])) << method;
    EXPECT_FALSE(same(views[0], views[2])) << method;
    const Image lobe = view("lobe", learned, {"--pixel", "12,14"});
    EXPECT_EQ(lobe.width(), kLobeWidth + (std::string(method) == "huang" ? kLobeHeight : 0));
    EXPECT_EQ(lobe.height(), kLobeHeight);
  }
}

TEST_F(RenderViewCommand, ATableWithoutStatesGainsNothing) {
  const std::string empty = table("huang", "0");
  EXPECT_TRUE(same(view("state", empty), view("state", "", {"--method", "huang"})))
      << "the states that it would have";
  const Image gain = view("gain", empty);
  // Viridis rises in green; beside the box it is black.
  EXPECT_FLOAT_EQ(gain.rgb(12, 14).g, viridis(0).g);
  for (int y = 0; y < gain.height(); ++y)
    for (int x = 0; x < gain.width(); ++x) ASSERT_LE(gain.rgb(x, y).g, 1.001f * viridis(0).g);
  const Outcome told =
      render({"--view", "lobe", "--pixel", "12,14", "--table-in", empty, "-o", file("lobe.png")});
  EXPECT_EQ(told.code, cmd::kExitOk);
  EXPECT_NE(told.err.find("knows nothing"), std::string::npos) << told.err;
  EXPECT_FALSE(same(gain, view("gain", table("huang"))));
}

TEST_F(RenderViewCommand, SaysWhatTheColoursMean) {
  const std::string learned = table("huang");
  const Outcome told = qray_command({"render", "cornell-box", "--size", "24x16", "--view", "gain",
                                     "--table-in", learned, "-o", file("gain.png")});
  ASSERT_EQ(told.code, cmd::kExitOk) << told.err;
  EXPECT_NE(told.err.find("1 (dark) to 64 (bright)"), std::string::npos) << told.err;
}

TEST_F(RenderViewCommand, SaysWhatIsWrong) {
  const std::string learned = table("huang"), out = file("out.png");
  const auto expect_refusal = [&](std::vector<std::string> more, const char* text) {
    more.insert(more.end(), {"-o", out});
    const Outcome wrong = render(more);
    EXPECT_EQ(wrong.code, cmd::kExitBadInput) << text;
    EXPECT_NE(wrong.err.find(text), std::string::npos) << wrong.err;
  };
  expect_refusal({"--view", "gain"}, "--table-in");
  expect_refusal({"--view", "albedo", "--table-in", learned}, "--table-in");
  expect_refusal({"--view", "lobe", "--table-in", learned}, "--pixel");
  expect_refusal({"--view", "beta", "--table-in", learned, "--pixel", "1,1"}, "--pixel");
  expect_refusal({"--pixel", "1,1"}, "--pixel");
  expect_refusal({"--view", "lobe", "--table-in", learned, "--pixel", "24,1"}, "/x");
  expect_refusal({"--view", "lobe", "--table-in", learned, "--pixel", "1,16"}, "/y");
  expect_refusal({"--view", "beta", "--table-in", learned, "--method", "ppg"}, "does not serve");
  expect_refusal({"--view", "beta", "--table-in", learned, "--method", "none"}, "does not serve");
  EXPECT_FALSE(std::filesystem::exists(out));
}

}  // namespace
}  // namespace qray::test
