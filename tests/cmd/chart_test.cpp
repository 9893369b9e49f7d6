// `qray chart` from its command line to its files. Runs are of a twentieth of a second: what they
// measure is not judged, but for what no noise can hide.
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/image/image_io.h"
#include "tests/cmd/command.h"
#include "tests/support/scratch.h"

namespace qray::test {
namespace {

using nlohmann::json;

std::vector<std::string> lines_of(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}
void write_lines(const std::filesystem::path& path, const std::vector<std::string>& lines) {
  std::ofstream file(path);
  for (const std::string& line : lines) file << line << "\n";
}
bool is_last(const std::string& line) { return line.find("\"last\":true") != std::string::npos; }

class ChartCommand : public ::testing::Test {
 protected:
  ChartCommand() : dir_(scratch_ / "chart") {}

  Outcome chart(std::vector<std::string> more = {}, const std::string& seconds = "0.05") const {
    std::vector<std::string> arguments{"chart", scene_,      "--quick",    "--seconds",
                                       seconds, "--methods", "none,huang", "--size",
                                       "32x24", "--threads", "1",          "--ref-seconds",
                                       "0.2",   "-q",        "-o",         dir_.string()};
    for (size_t i = 0; i + 1 < more.size(); i += 2) {  // replaces an option, or adds it
      const auto old = std::find(arguments.begin(), arguments.end(), more[i]);
      if (old == arguments.end()) {
        arguments.insert(arguments.end(), {more[i], more[i + 1]});
      } else {
        *std::next(old) = more[i + 1];
      }
    }
    if (more.size() % 2 == 1) arguments.push_back(more.back());
    return qray_command(arguments);
  }
  json summary() const {
    std::ifstream file(dir_ / "summary.json");
    return json::parse(file, nullptr, false);
  }
  std::vector<std::string> results() const { return lines_of(dir_ / "results.jsonl"); }

  ScratchFolder scratch_;
  const std::filesystem::path dir_;
  std::string scene_ = "cornell-box";
};

TEST_F(ChartCommand, WritesResultsConclusionsAndPictures) {
  const Outcome done =
      chart({"--methods", "none,huang-published,huang:grid=12;nee=off", "--warm-turn", "20"});
  ASSERT_EQ(done.code, cmd::kExitOk) << done.err;

  const std::vector<std::string> lines = results();
  ASSERT_GT(lines.size(), 12u);
  const json header = json::parse(lines[0]);
  EXPECT_EQ(header["flags"]["--seconds"], "0.05");
  EXPECT_EQ(header["flags"]["--warm"], "on");
  EXPECT_NE(header["machine"].get<std::string>().find("threads"), std::string::npos);
  EXPECT_NE(header["commit"], "");
  const json reference = json::parse(lines[1]);
  EXPECT_EQ(reference["line"], "reference");
  EXPECT_EQ(reference["scene"], "cornell-box");
  EXPECT_GT(reference["floor_relmse"], 0);
  EXPECT_TRUE(std::filesystem::exists(dir_ / reference["path"].get<std::string>()));
  EXPECT_EQ(std::count_if(lines.begin(), lines.end(), is_last), 2 * (3 + 2));
  for (size_t i = 2; i < lines.size(); ++i) {
    const json row = json::parse(lines[i]);
    EXPECT_GT(row["relmse"], 0);
    EXPECT_GT(row["rays"], 0);
    EXPECT_EQ(row["table_bytes"] > 0, row["method"] != "none");
    EXPECT_LT(row["seconds"], 10) << "a run of a twentieth of a second";
  }

  const json s = summary();
  EXPECT_EQ(s["commit"], header["commit"]);
  EXPECT_EQ(s["seeds"], json({1, 2}));
  const json& methods = s["scenes"][0]["methods"];
  ASSERT_EQ(methods.size(), 5u);
  EXPECT_EQ(methods[0]["method"], "none");
  EXPECT_EQ(methods[1]["method"], "huang-published");
  EXPECT_EQ(methods[1]["biased"], true);
  EXPECT_EQ(methods[2]["warm"], true);
  EXPECT_EQ(methods[3]["method"], "huang:grid=12;nee=off");
  EXPECT_EQ(methods[3]["claims_unbiased"], true);

  for (const char* file : {"chart.svg", "chart.png", "index.html", "table.md"})
    EXPECT_GT(std::filesystem::file_size(dir_ / file), 0u) << file;
  for (const char* picture :
       {"reference", "none", "none-error", "huang-published-warm", "huang-published-warm-error",
        "huang-grid-12-nee-off", "huang-grid-12-nee-off-error", "huang-grid-12-nee-off-warm"}) {
    const auto image = read_image(dir_ / "cornell-box" / (std::string(picture) + ".png"));
    ASSERT_TRUE(image.ok()) << picture;
    EXPECT_EQ(image.value().width(), 32);
  }
  EXPECT_NE(done.out.find("huang-published, warm"), std::string::npos);
  EXPECT_NE(done.out.find("biased"), std::string::npos);
}

TEST_F(ChartCommand, RecoveredPicturesAreMeasuredAsTheyAre) {
  const char* recovered = "none:pixels=quarter;recover=default";
  const Outcome done = chart({"--methods", std::string("none,none:pixels=quarter,") + recovered});
  ASSERT_EQ(done.code, cmd::kExitOk) << done.err;
  const json methods = summary()["scenes"][0]["methods"];
  ASSERT_EQ(methods.size(), 3u);
  EXPECT_EQ(methods[2]["method"], recovered);
  EXPECT_EQ(methods[2]["claims_unbiased"], false);
  const auto last_error = [&](int i) {
    return methods[i]["points"].back()["relmse"].get<double>();
  };
  EXPECT_LT(last_error(2), 0.5 * last_error(1)) << "the others are black where nothing was sampled";
}

TEST_F(ChartCommand, MeasuresThatThePublishedMethodBrightens) {
  scene_ = "thesis-room";
  const std::string methods =
      "none,huang-published:nee=off;learning=100,huang:nee=off;learning=100";
  ASSERT_EQ(chart({"--methods", methods, "--seeds", "3", "--warm"}, "0.1").code, cmd::kExitOk);
  const json results = summary()["scenes"][0]["methods"];
  ASSERT_EQ(results.size(), 5u);
  const json &published = results[2], &exact = results[4];
  ASSERT_EQ(published["method"], "huang-published:nee=off;learning=100");
  ASSERT_EQ(published["warm"], true);
  EXPECT_GT(published["brightness"], 1.1);  // 1.2 to 1.3 so soon
  EXPECT_GT(published["bias_z"], 0);
  EXPECT_EQ(published["biased"], true);
  ASSERT_EQ(exact["warm"], true);
  EXPECT_NEAR(exact["brightness"], 1, 0.08);
}

TEST_F(ChartCommand, GoesOnWhereItEnded) {
  ASSERT_EQ(chart().code, cmd::kExitOk);
  const std::vector<std::string> whole = results();
  const size_t second_run =
      1 + static_cast<size_t>(std::find_if(whole.begin(), whole.end(), is_last) - whole.begin());
  // One run and what a crash left of the next: a row without its run's end, and half a row.
  std::vector<std::string> left(whole.begin(),
                                whole.begin() + static_cast<std::ptrdiff_t>(second_run) + 1);
  write_lines(dir_ / "results.jsonl", left);
  std::ofstream(dir_ / "results.jsonl", std::ios::app) << whole[second_run + 1].substr(0, 60);
  const auto reference_made =
      std::filesystem::last_write_time(dir_ / json::parse(whole[1])["path"].get<std::string>());

  ASSERT_EQ(chart().code, cmd::kExitOk);
  const std::vector<std::string> again = results();
  EXPECT_TRUE(std::equal(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(second_run),
                         again.begin()))
      << "the header, the reference and the first run are kept as they were";
  EXPECT_EQ(std::count_if(again.begin(), again.end(), is_last), 4);
  EXPECT_TRUE(std::none_of(again.begin(), again.end(), [&](const std::string& line) {
    return line == whole[second_run];
  })) << "the row of the run that had not ended is gone";
  EXPECT_EQ(reference_made, std::filesystem::last_write_time(
                                dir_ / json::parse(again[1])["path"].get<std::string>()));

  // Complete: nothing is measured, even without the reference; the conclusions are written again.
  const json before = summary();
  std::filesystem::remove_all(dir_ / "references");
  std::filesystem::remove(dir_ / "summary.json");
  ASSERT_EQ(chart().code, cmd::kExitOk);
  EXPECT_EQ(results(), again);
  EXPECT_EQ(summary(), before);

  // Not complete, and the reference of the runs so far is lost.
  write_lines(dir_ / "results.jsonl", left);
  const Outcome lost = chart();
  EXPECT_EQ(lost.code, cmd::kExitBadInput);
  EXPECT_NE(lost.err.find("expected the reference"), std::string::npos) << lost.err;
}

TEST_F(ChartCommand, RefusesToMixFlagsScenesAndCommits) {
  ASSERT_EQ(chart().code, cmd::kExitOk);
  const std::vector<std::string> before = results();
  const Outcome other = chart({"--methods", "none"}, "0.06");
  EXPECT_EQ(other.code, cmd::kExitBadInput);
  EXPECT_NE(
      other.err.find("--methods was 'none,huang', is 'none'; --seconds was '0.05', is '0.06'"),
      std::string::npos)
      << other.err;
  EXPECT_EQ(results(), before);

  std::vector<std::string> altered = before;
  json reference = json::parse(altered[1]);
  reference["scene_hash"] = "of another";
  altered[1] = reference.dump();
  write_lines(dir_ / "results.jsonl", altered);
  EXPECT_NE(chart().err.find("has changed since"), std::string::npos);

  altered = {before.begin(), before.end() - 1};  // the last run is not complete
  json header = json::parse(altered[0]);
  header["commit"] = "0123";
  altered[0] = header.dump();
  write_lines(dir_ / "results.jsonl", altered);
  EXPECT_NE(chart().err.find("was begun by commit 0123"), std::string::npos);

  altered[2] = "{}";
  write_lines(dir_ / "results.jsonl", altered);
  EXPECT_NE(chart().err.find("results.jsonl:3"), std::string::npos);

  ASSERT_EQ(chart({"--fresh"}).code, cmd::kExitOk);
  EXPECT_EQ(json::parse(results()[0])["commit"], json::parse(before[0])["commit"]);
}

TEST_F(ChartCommand, TakesAPictureAsTheTruth) {
  const std::string truth = (scratch_ / "truth.exr").string();
  ASSERT_EQ(qray_command({"render", "cornell-box", "--size", "32x24", "--method", "none", "--spp",
                          "64", "-q", "-o", truth})
                .code,
            cmd::kExitOk);
  const std::vector<std::string> with_ref{
      "chart",  "cornell-box", "--quick", "--seconds", "0.05", "--methods", "none",
      "--size", "32x24",       "-q",      "--ref",     truth,  "-o",        dir_.string()};
  ASSERT_EQ(qray_command(with_ref).code, cmd::kExitOk);
  const json reference = summary()["scenes"][0]["reference"];
  EXPECT_EQ(reference["path"], truth);
  EXPECT_EQ(reference["floor_known"], false);

  std::vector<std::string> other_size = with_ref;
  other_size[8] = "33x24";
  other_size.push_back("--fresh");
  EXPECT_NE(qray_command(other_size).err.find("is 32x24, expected 33x24"), std::string::npos);
}

TEST_F(ChartCommand, ReferencesAreShared) {
  const std::string cache = (scratch_ / "cache").string();
  ASSERT_EQ(chart({"--ref-cache", cache}).code, cmd::kExitOk);
  const json first = summary()["scenes"][0]["reference"];
  EXPECT_EQ(first["path"].get<std::string>().rfind(cache, 0), 0u);
  ASSERT_EQ(chart({"--ref-cache", cache, "--ref-seconds", "0.1", "--fresh"}).code, cmd::kExitOk);
  EXPECT_EQ(summary()["scenes"][0]["reference"], first) << "a longer one is reused";
}

TEST_F(ChartCommand, SaysWhatItExpected) {
  const auto refused = [&](std::vector<std::string> more, const char* expected) {
    const Outcome done = chart(std::move(more));
    EXPECT_EQ(done.code, cmd::kExitBadInput) << expected;
    EXPECT_NE((done.out + done.err).find(expected), std::string::npos) << done.out << done.err;
  };
  refused({"--methods", "none,nope"}, "expected one of none, huang-published, huang");
  refused({"--methods", "huang:grid=0"}, "/grid: expected 1..");
  refused({"--size", "32"}, "expected WIDTHxHEIGHT");
  refused({"--seeds", "1"}, "--seeds");
  refused({"--ref-method", "huang-published"}, "without bias");
  refused({"cornell-box"}, "another scene is called cornell-box");
  refused({"no-such-scene"}, "no-such-scene");
  EXPECT_EQ(chart().code, cmd::kExitOk) << "what was refused leaves nothing behind";
}

}  // namespace
}  // namespace qray::test
