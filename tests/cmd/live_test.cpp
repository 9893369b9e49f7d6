#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "core/cmd/commands.h"
#include "tests/cmd/command.h"
#include "tests/support/scratch.h"

namespace qray {
namespace {

class LiveCommand : public ::testing::Test {
 protected:
  std::string flight(const std::string& text) {
    const auto path = folder_ / "flight.json";
    std::ofstream(path) << text;
    return path.string();
  }
  test::ScratchFolder folder_;
  const std::string out_ = (folder_ / "out").string(), cache_ = (folder_ / "cache").string();
};

TEST_F(LiveCommand, FliesAndMeasures) {
  const std::string way = flight(R"({"keys": [
      {"seconds": 0},
      {"seconds": 0.4, "position": [0.25, 0.3, -0.75], "cut": true, "lights": [0.5]},
      {"seconds": 1, "position": [0.3, 0.25, -0.7]}]})");
  const auto done = test::qray_command({"live",
                                        "cornell-box",
                                        "--flight",
                                        way,
                                        "-o",
                                        out_,
                                        "--cache",
                                        cache_,
                                        "--size",
                                        "32x32",
                                        "--budget-ms",
                                        "20",
                                        "--references",
                                        "1",
                                        "--reference-seconds",
                                        "0.1",
                                        "--variants",
                                        "full,plain,fresh",
                                        "--rest",
                                        "1.5",
                                        "-q"});
  ASSERT_EQ(done.code, cmd::kExitOk) << done.err;
  EXPECT_NE(done.out.find("0.5 s after the picture changed at 0.40 s"), std::string::npos);
  EXPECT_NE(done.out.find("a job of as many samples"), std::string::npos) << done.out;
  for (const char* name : {"1000-full.png", "1000-plain.png", "900-fresh.png", "900-reference.png"})
    EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(out_) / name)) << name;
  std::ifstream lines(std::filesystem::path(out_) / "flight.jsonl");
  std::vector<std::string> variants;
  for (std::string line; std::getline(lines, line);) {
    const auto row = nlohmann::json::parse(line);
    variants.push_back(row["variant"]);
    EXPECT_GT(row["frames"], 5) << line;
    EXPECT_GT(row["relmse"], 0) << line;
    EXPECT_GT(row["paths_per_frame"], 10) << line;
  }
  EXPECT_EQ(variants, (std::vector<std::string>{"full", "plain", "fresh"}));
}

TEST_F(LiveCommand, RefusesWhatDoesNotFit) {
  const std::string way = flight(R"({"keys": [{"seconds": 0}, {"seconds": 1, "lights": [1, 1]}]})");
  const auto run = [&](std::vector<std::string> more) {
    std::vector<std::string> line = {"live", "cornell-box", "-o", out_, "--cache", cache_, "-q"};
    line.insert(line.end(), more.begin(), more.end());
    return test::qray_command(line);
  };
  const auto lights = run({"--flight", way});
  EXPECT_EQ(lights.code, cmd::kExitBadInput);
  EXPECT_NE(lights.err.find("as many factors as the scene has lights"), std::string::npos);
  const auto odd = run({"--flight", way, "--size", "31x32"});
  EXPECT_EQ(odd.code, cmd::kExitBadInput);
  EXPECT_NE(odd.err.find("even"), std::string::npos) << odd.err;
  EXPECT_EQ(run({"--flight", way, "--variants", "magic"}).code, cmd::kExitBadInput);
  EXPECT_EQ(run({"--flight", "nowhere.json"}).code, cmd::kExitBadInput);
}

}  // namespace
}  // namespace qray
