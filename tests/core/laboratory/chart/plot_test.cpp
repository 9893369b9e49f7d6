// The drawing by gnuplot: what is in the files that a chart's folder gets.
#include "core/laboratory/chart/plot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "core/base/file.h"
#include "core/image/image_io.h"
#include "core/laboratory/chart/names.h"
#include "tests/core/laboratory/chart/made_up_summary.h"
#include "tests/support/scratch.h"

namespace qray {
namespace {

std::string text_of(const std::filesystem::path& path) {
  const Result<Bytes> bytes = read_file(path, 1 << 24);
  if (!bytes) return bytes.error().text();
  return {bytes.value().begin(), bytes.value().end()};
}

size_t count(const std::string& text, const std::string& part) {
  size_t n = 0;
  for (size_t at = 0; (at = text.find(part, at)) != std::string::npos; at += part.size()) ++n;
  return n;
}

// Gives the test's own process another PATH while it lives.
class OtherPath {
 public:
  explicit OtherPath(const std::string& path) : before_(std::getenv("PATH")) {
    ::setenv("PATH", path.c_str(), 1);
  }
  ~OtherPath() { ::setenv("PATH", before_.c_str(), 1); }

 private:
  std::string before_;
};

TEST(ChartPlot, DrawsAllScenesTogetherAndEachAlone) {
  const test::ScratchFolder folder;
  ChartSummary summary = test::made_up_summary();
  summary.scenes.push_back(test::made_up_scene("Lamp room", 1e-7));
  summary.scenes.push_back(test::made_up_scene("outside", 0));
  summary.scenes[2].reference.floor_known = false;
  const Status drawn = write_plots(summary, folder.path());
  ASSERT_TRUE(drawn.ok()) << drawn.error().text();

  const Result<Image> png = read_image(folder / "chart.png");
  ASSERT_TRUE(png.ok()) << png.error().text();
  EXPECT_EQ(png.value().width(), 2 * 2 * 480);  // two columns of panels, twice as fine
  const std::string all = text_of(folder / "chart.svg");
  for (const char* words : {">ajar-door<", ">Lamp room<", ">outside<", ">seconds<",
                            ">error (relMSE)<", ">huang-published, biased<"})
    EXPECT_NE(all.find(words), std::string::npos) << words;
  EXPECT_EQ(count(all, ">the reference's own error, 0.0002<"), 1);
  EXPECT_EQ(count(all, ">the reference's own error, 1e-07, is below this<"), 1);
  EXPECT_EQ(count(all, ">the reference's own error is not known<"), 1);
  const std::string alone = text_of(folder / chart_file_name("Lamp room") / "chart.svg");
  EXPECT_NE(alone.find(">Lamp room<"), std::string::npos);
  EXPECT_EQ(alone.find(">ajar-door<"), std::string::npos);
  EXPECT_TRUE(std::filesystem::exists(folder / "ajar-door" / "chart.svg"));
}

TEST(ChartPlot, LineEndsWhereItReachesTheFloor) {
  const test::ScratchFolder folder;
  ChartSummary summary = test::made_up_summary();
  std::vector<ChartPoint>& points = summary.scenes[0].methods[2].points;
  points.resize(5);
  for (size_t i = 0; i < points.size(); ++i) {
    points[i].seconds = 1000 + static_cast<double>(i);
    points[i].at_floor = i >= 2;
  }
  points[1].relmse = 0;  // not on a logarithmic axis
  ASSERT_TRUE(write_plots(summary, folder.path()).ok());
  const std::string data = text_of(folder / "chart.dat");
  EXPECT_EQ(count(data, "\n1 3 100"), 2);
  EXPECT_EQ(count(data, "\n1 3 1000 "), 1);
  EXPECT_EQ(count(data, "\n1 3 1002 "), 1);
}

TEST(ChartPlot, BiasedLinesAreDashedAndWarmOnesSaySo) {
  const test::ScratchFolder folder;
  ChartSummary summary = test::made_up_summary();
  summary.scenes[0].methods.erase(summary.scenes[0].methods.begin() + 1);
  ASSERT_TRUE(write_plots(summary, folder.path()).ok());
  const std::string good = text_of(folder / "chart.svg");
  EXPECT_EQ(count(good, "dasharray"), 0);
  EXPECT_EQ(count(good, "biased"), 0);
  EXPECT_EQ(count(good, "warm"), 0);
  MethodSummary warm = summary.scenes[0].methods[1];
  warm.warm = warm.biased = true;
  summary.scenes[0].methods.push_back(warm);
  summary.scenes.push_back(test::made_up_scene("another", 1e-4));
  summary.scenes[1].methods[2].warm = true;
  ASSERT_TRUE(write_plots(summary, folder.path()).ok());
  const std::string biased = text_of(folder / "ajar-door" / "chart.svg");
  EXPECT_EQ(count(biased, "dasharray"), 2);  // its line and its sample in the legend
  EXPECT_EQ(count(biased, ">huang (warm), biased<"), 1);
  EXPECT_EQ(count(biased, ">huang<"), 1);
  const std::string all = text_of(folder / "chart.svg");
  EXPECT_EQ(count(all, ">huang (warm), biased in 1 of 2 scenes<"), 1);
}

TEST(ChartPlot, LabelsAreShownVerbatimAndNeverRun) {
  const char* const kNasty = "'; system('touch ran'); \"; `touch ran` \\047 \\\" @term $0 \\";
  const test::ScratchFolder folder;
  ChartSummary summary = test::made_up_summary();
  summary.scenes[0].methods[0].method = "huang:grid=12_a^{b}@c";
  summary.scenes[0].methods[2].method = kNasty;
  summary.scenes[0].reference.scene = "it's <\n>";
  const Status drawn = write_plots(summary, folder.path());
  ASSERT_TRUE(drawn.ok()) << drawn.error().text();
  const std::string svg = text_of(folder / "chart.svg");
  EXPECT_EQ(count(svg, ">huang:grid=12_a^{b}@c<"), 1);
  std::string shown = kNasty;
  std::replace(shown.begin(), shown.end(), '`', '\'');  // the one letter that cannot be had
  EXPECT_EQ(count(svg, ">" + shown + "<"), 1) << svg;
  EXPECT_EQ(count(svg, ">it's &lt; ><"), 1);
  EXPECT_FALSE(std::filesystem::exists(folder / "ran"));
}

TEST(ChartPlot, WithoutGnuplotSaysWhichPackageAndKeepsTheScript) {
  const test::ScratchFolder folder;
  {
    const OtherPath nowhere((folder / "no-programs").string());
    const Status drawn = write_plots(test::made_up_summary(), folder.path());
    ASSERT_FALSE(drawn.ok());
    EXPECT_EQ(drawn.error().code, ErrorCode::kNotFound);
    EXPECT_NE(drawn.error().text().find("apt-get install gnuplot-nox"), std::string::npos);
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "chart.svg"));
  const std::string again = "cd '" + folder.path().string() + "' && gnuplot chart.gp";
  EXPECT_EQ(std::system(again.c_str()), 0);
  EXPECT_TRUE(std::filesystem::exists(folder / "chart.svg"));
}

TEST(ChartPlot, GnuplotsOwnWordsAreInTheError) {
  const test::ScratchFolder folder;
  std::filesystem::create_directory(folder / "chart.svg");  // in the way
  const Status drawn = write_plots(test::made_up_summary(), folder.path());
  ASSERT_FALSE(drawn.ok());
  EXPECT_EQ(drawn.error().code, ErrorCode::kIo);
  EXPECT_NE(drawn.error().message.find("cannot open file"), std::string::npos)
      << drawn.error().text();
}

TEST(ChartPlot, AnEmptyLineIsDrawnAsNothingAndNoMethodIsAnError) {
  const test::ScratchFolder folder;
  ChartSummary summary = test::made_up_summary();
  for (MethodSummary& method : summary.scenes[0].methods) method.points.clear();
  EXPECT_TRUE(write_plots(summary, folder.path()).ok());
  summary.scenes[0].methods.clear();
  const Status drawn = write_plots(summary, folder.path());
  ASSERT_FALSE(drawn.ok());
  EXPECT_EQ(drawn.error().code, ErrorCode::kInvalid);
}

}  // namespace
}  // namespace qray
