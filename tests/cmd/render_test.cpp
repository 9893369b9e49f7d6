#include <fstream>
#include <nlohmann/json.hpp>

#include "core/image/image_io.h"
#include "core/image/picture_layers.h"
#include "tests/cmd/command.h"
#include "tests/support/scratch.h"

namespace qray::test {
namespace {

nlohmann::json read_json(const std::filesystem::path& path) {
  std::ifstream file(path);
  return nlohmann::json::parse(file, nullptr, false);
}

// Not the file's bytes: it holds the time of writing.
std::vector<float> pixels_of(const std::filesystem::path& path) {
  const auto image = read_image(path);
  EXPECT_TRUE(image.ok()) << path;
  if (!image.ok()) return {};
  return {image.value().data().begin(), image.value().data().end()};
}

class RenderCommand : public ::testing::Test {
 protected:
  std::string file(const char* name) const { return (scratch_ / name).string(); }
  Outcome render(std::vector<std::string> more) const {
    std::vector<std::string> arguments{"render", "cornell-box", "--size", "24x16", "-q"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return qray_command(arguments);
  }
  ScratchFolder scratch_;
};

TEST_F(RenderCommand, PassesAreLayersOfAFileBesideThePicture) {
  const Outcome done = render({"--method", "none", "--spp", "4", "--passes", "normal,direct",
                               "--passes", "cryptomatte-object", "--light-groups", "each",
                               "--passes-out", file("layers.exr"), "-o", file("out.exr")});
  ASSERT_EQ(done.code, cmd::kExitOk) << done.err;
  const std::vector<std::string> names = read_layer_names(file("layers.exr")).value();
  for (const char* name : {"", "normal", "direct", "CryptoObject00", "Combined_light_5"})
    EXPECT_NE(std::ranges::find(names, name), names.end()) << name;
  const Outcome dark = render({"--method", "none", "--spp", "4", "--light-groups", "each", "--mix",
                               "0", "-o", file("dark.exr")});
  ASSERT_EQ(dark.code, cmd::kExitOk) << dark.err;
  for (const float v : pixels_of(file("dark.exr"))) ASSERT_EQ(v, 0);
  for (const std::vector<std::string>& wrong :
       {std::vector<std::string>{"--passes", "normal", "-o", file("a.exr")},
        {"--passes-out", file("l.exr"), "-o", file("a.exr")},
        {"--passes", "norm", "--passes-out", file("l.exr"), "-o", file("a.exr")},
        {"--passes", "normal", "--passes-out", file("l.png"), "-o", file("a.exr")},
        {"--mix", "2", "-o", file("a.exr")},
        {"--light-groups", "each", "--mix", "2;2", "-o", file("a.exr")}})
    EXPECT_NE(render(wrong).code, cmd::kExitOk) << wrong[0];
}

TEST_F(RenderCommand, ExposesThePngAndNotTheExr) {
  const auto mean_of = [&](std::vector<std::string> more, const char* name) {
    more.insert(more.end(), {"--method", "none", "--spp", "4", "-o", file(name)});
    const Outcome done = render(more);
    EXPECT_EQ(done.code, cmd::kExitOk) << done.err;
    double sum = 0;
    const std::vector<float> pixels = pixels_of(file(name));
    for (const float v : pixels) sum += static_cast<double>(v);
    return sum / static_cast<double>(pixels.size());
  };
  const double plain = mean_of({}, "plain.png");
  EXPECT_GT(mean_of({"--exposure", "2"}, "bright.png"), plain * 1.2);
  EXPECT_LT(mean_of({"--exposure", "-12"}, "dark.png"), 0.05);
  const double automatic = mean_of({"--exposure", "auto"}, "auto.png");
  EXPECT_GT(automatic, 0.2);  // a middle grey is .46; beside the box is black
  EXPECT_LT(automatic, 0.65);
  for (const std::vector<std::string>& wrong :
       {std::vector<std::string>{"--exposure", "1", "-o", file("a.exr")},
        {"--exposure", "bright", "-o", file("a.png")},
        {"--exposure", "1", "--view", "albedo", "-o", file("a.png")}})
    EXPECT_NE(render(wrong).code, cmd::kExitOk);
}

TEST_F(RenderCommand, WritesAPictureAndItsStatistics) {
  const Outcome done = render({"--method", "none", "--spp", "4", "--seed", "9", "--threads", "2",
                               "--json", file("stats.json"), "-o", file("out.exr")});
  ASSERT_EQ(done.code, cmd::kExitOk) << done.err;
  const auto image = read_image(file("out.exr"));
  ASSERT_TRUE(image.ok());
  EXPECT_EQ(image.value().width(), 24);
  EXPECT_EQ(image.value().height(), 16);
  float sum = 0;
  for (float v : image.value().data()) sum += v;
  EXPECT_GT(sum, 1.0f);

  const nlohmann::json stats = read_json(file("stats.json"));
  ASSERT_TRUE(stats.is_object());
  EXPECT_EQ(stats["method"], "none");
  EXPECT_EQ(stats["samples"], 4);
  EXPECT_EQ(stats["seed"], 9);
  EXPECT_EQ(stats["threads"], 2);
  EXPECT_EQ(stats["paths"], 4 * 24 * 16);
  EXPECT_GE(stats["rays"], stats["paths"]);
  EXPECT_EQ(stats["dropped_samples"], 0);
  EXPECT_NEAR(stats["share_tracing"].get<double>() + stats["share_guiding"].get<double>() +
                  stats["share_rest"].get<double>(),
              1, 1e-6);
}

TEST_F(RenderCommand, GivesTheSamePixelsForAnyNumberOfThreads) {
  for (const char* threads : {"1", "3"})
    ASSERT_EQ(render({"--spp", "8", "--threads", threads, "-o",
                      file((std::string(threads) + ".exr").c_str())})
                  .code,
              cmd::kExitOk);
  EXPECT_EQ(pixels_of(file("1.exr")), pixels_of(file("3.exr")));
}

TEST_F(RenderCommand, ReplaysPasses) {
  ASSERT_EQ(render({"--spp", "7", "--json", file("a.json"), "-o", file("a.exr")}).code, 0);
  const nlohmann::json stats = read_json(file("a.json"));
  std::string passes;
  for (int n : stats["passes"].get<std::vector<int>>())
    passes += (passes.empty() ? "" : ",") + std::to_string(n);
  const Outcome replayed = render({"--replay", passes, "--learning-samples",
                                   stats["learning_samples"].dump(), "-o", file("b.exr")});
  ASSERT_EQ(replayed.code, 0) << replayed.err;
  EXPECT_EQ(pixels_of(file("a.exr")), pixels_of(file("b.exr")));
}

TEST_F(RenderCommand, GrowsATable) {
  ASSERT_EQ(render({"--spp", "8", "--table-out", file("one.qrt"), "-o", file("a.exr")}).code, 0);
  const Outcome warm = render({"--spp", "8", "--seed", "2", "--table-in", file("one.qrt"),
                               "--table-out", file("two.qrt"), "-o", file("b.exr")});
  ASSERT_EQ(warm.code, 0) << warm.err;
  const auto info = [&](const char* name) {
    const Outcome told = qray_command({"table", "info", file(name), "--json"});
    EXPECT_EQ(told.code, 0) << told.err;
    return nlohmann::json::parse(told.out, nullptr, false);
  };
  const nlohmann::json one = info("one.qrt"), two = info("two.qrt");
  EXPECT_EQ(one["method"], "adaptive");
  EXPECT_EQ(two["method"], "adaptive");
  EXPECT_EQ(two["parents"], nlohmann::json::array({one["id"]}));
  EXPECT_EQ(two["geometry"], one["geometry"]);
  EXPECT_GT(two["samples_seen"], one["samples_seen"]);
}

TEST_F(RenderCommand, KeepsATableWithinItsMemory) {
  const std::vector<std::string> fine{"--method", "huang:grid=500", "--spp",       "32",
                                      "--json",   file("s.json"),   "--table-out", file("t.qrt"),
                                      "-o",       file("a.exr")};
  ASSERT_EQ(render(fine).code, 0);
  EXPECT_GT(read_json(file("s.json"))["table_bytes"], 1 << 20);
  EXPECT_EQ(read_json(file("s.json"))["table_refused"], 0);
  const Outcome refused = render({"--method", "huang:grid=500", "--spp", "4", "--table-mib", "1",
                                  "--table-in", file("t.qrt"), "-o", file("b.exr")});
  EXPECT_EQ(refused.code, cmd::kExitBadInput);
  EXPECT_NE(refused.err.find(" 1048576 bytes"), std::string::npos) << refused.err;
  std::vector<std::string> capped = fine;
  capped.insert(capped.end(), {"--table-mib", "1"});
  ASSERT_EQ(render(capped).code, 0);
  EXPECT_LE(read_json(file("s.json"))["table_bytes"], 1 << 20);
  EXPECT_GT(read_json(file("s.json"))["table_refused"], 0);
}

TEST_F(RenderCommand, RefusesAnotherScenesTable) {
  ASSERT_EQ(render({"--spp", "4", "--table-out", file("box.qrt"), "-o", file("a.exr")}).code, 0);
  const Outcome other = qray_command({"render", "ajar-door", "--size", "16x16", "--spp", "4", "-q",
                                      "--table-in", file("box.qrt"), "-o", file("b.exr")});
  EXPECT_EQ(other.code, cmd::kExitBadInput);
  EXPECT_NE(other.err.find("another scene"), std::string::npos) << other.err;
  EXPECT_FALSE(std::filesystem::exists(file("b.exr")));
}

TEST_F(RenderCommand, DrawsViewsWithoutLight) {
  for (const char* view : {"albedo", "normal", "state"}) {
    const std::string name = file((std::string(view) + ".exr").c_str());
    ASSERT_EQ(render({"--view", view, "-o", name}).code, 0) << view;
    const auto image = read_image(name);
    ASSERT_TRUE(image.ok());
    float brightest = 0;
    for (float v : image.value().data()) brightest = std::max(brightest, v);
    EXPECT_GT(brightest, 0.2f) << view;
    EXPECT_LE(brightest, 1.0f) << view;
  }
}

TEST_F(RenderCommand, SaysWhatIsWrong) {
  const auto expect_refusal = [&](const std::vector<std::string>& more, const char* text) {
    const Outcome wrong = render(more);
    EXPECT_EQ(wrong.code, cmd::kExitBadInput) << text;
    EXPECT_NE(wrong.err.find(text), std::string::npos) << wrong.err;
  };
  const std::string out = file("out.exr");
  expect_refusal({"-o", file("out.jpeg")}, ".exr or .png");
  expect_refusal({"-o", file("nowhere/out.exr")}, "no such folder");
  expect_refusal({"--method", "magic", "-o", out}, "magic");
  expect_refusal({"--spp", "0", "-o", out}, "/samples");
  expect_refusal({"--spp", "4", "--seconds", "1", "-o", out}, "excludes");
  expect_refusal({"--method", "none", "--table-out", file("t"), "-o", out}, "--table-out");
  expect_refusal({"--view", "state", "--table-out", file("t"), "-o", out}, "--view");
  expect_refusal({"--table-in", file("none.qrt"), "-o", out}, "none.qrt");
  EXPECT_FALSE(std::filesystem::exists(out));
  EXPECT_EQ(qray_command({"render", "no-such-scene", "-o", out}).code, cmd::kExitBadInput);
}

TEST(QrayCommand, HasHelpAndAVersion) {
  EXPECT_EQ(qray_command({"--help"}).code, cmd::kExitOk);
  EXPECT_NE(qray_command({"--help"}).out.find("Exit codes"), std::string::npos);
  EXPECT_NE(qray_command({"--version"}).out.find('.'), std::string::npos);
  EXPECT_EQ(qray_command({}).code, cmd::kExitBadInput);
  EXPECT_EQ(qray_command({"paint"}).code, cmd::kExitBadInput);
}

}  // namespace
}  // namespace qray::test
