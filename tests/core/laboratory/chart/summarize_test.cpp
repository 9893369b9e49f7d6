#include "core/laboratory/chart/summarize.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/laboratory/chart/tables.h"

namespace qray {
namespace {

// Runs whose error is `factor(seed)` / seconds, looked at after 1, 2, 4, 8 and 16 seconds.
struct MadeUp {
  std::string method;
  double factor = 1;
  double seed_spread = 1;  // each seed's factor is this to the power of -1, 0, 1
  double brightness = 1, brightness_step = 0;
  bool warm = false;
  double per_second = 10;  // samples a pixel
};

void add_runs(std::vector<ChartRow>& rows, const MadeUp& m) {
  for (int seed = 1; seed <= 3; ++seed)
    for (int point = 0; point < 5; ++point) {
      ChartRow row;
      row.scene = "room";
      row.method = m.method;
      row.warm = m.warm;
      row.seed = static_cast<uint64_t>(seed);
      row.point = point;
      row.last = point == 4;
      row.seconds = std::exp2(point);
      row.samples_per_pixel = static_cast<uint64_t>(m.per_second * row.seconds);
      row.relmse = m.factor * std::pow(m.seed_spread, seed - 2) / row.seconds;
      row.relmse_trimmed = row.relmse / 2;
      row.flip = std::sqrt(row.relmse);
      row.mean_ratio = m.brightness + m.brightness_step * (seed - 2);
      row.table_bytes = 2048;
      rows.push_back(row);
    }
}

ChartReference reference_with_floor(double floor) {
  ChartReference r;
  r.scene = "room";
  r.width = r.height = 8;
  r.floor_relmse = floor;
  r.floor_trimmed = floor / 2;
  r.mean_standard_error = 1e-3;
  return r;
}

TEST(SummarizeScene, EfficiencyAndTimesOfMethodsThatAreKnown) {
  std::vector<ChartRow> rows;
  add_runs(rows, {.method = "none", .factor = 1.6, .seed_spread = 2});
  add_runs(rows, {.method = "huang", .factor = 0.4, .seed_spread = 2});
  add_runs(rows, {.method = "huang", .factor = 0.2, .warm = true});
  const SceneSummary s = summarize_scene(reference_with_floor(1e-6), rows, 3);
  ASSERT_EQ(s.methods.size(), 3u);
  const MethodSummary &none = s.methods[0], &huang = s.methods[1], &warm = s.methods[2];
  EXPECT_EQ(none.method, "none");
  EXPECT_FALSE(huang.warm);
  EXPECT_TRUE(warm.warm);
  EXPECT_EQ(huang.seeds, 3);
  EXPECT_NEAR(none.efficiency->value, 1, 1e-12);
  EXPECT_NEAR(none.efficiency->high, 1, 1e-12);
  EXPECT_EQ(none.time_to_equal_error, 1);
  // Its seeds are as lucky as none's, so the ratio is 4 in each pair: no spread.
  EXPECT_NEAR(huang.efficiency->value, 4, 1e-9);
  EXPECT_NEAR(huang.efficiency->low, 4, 1e-9);
  EXPECT_NEAR(huang.efficiency_trimmed->value, 4, 1e-9);
  EXPECT_NEAR(*huang.time_to_equal_error, 0.25, 1e-9);
  EXPECT_NEAR(*huang.slope, -1, 1e-9);
  // Ratios of 4, 8 and 16.
  const double half = 4.30265 * std::log(2) / std::sqrt(3.0);
  EXPECT_NEAR(warm.efficiency->value, 8, 1e-9);
  EXPECT_NEAR(warm.efficiency->low, 8 * std::exp(-half), 1e-3);
  EXPECT_NEAR(warm.efficiency->high, 8 * std::exp(half), 1e-3);
  ASSERT_EQ(huang.points.size(), 5u);
  EXPECT_NEAR(huang.points[1].relmse, 0.2, 1e-12);
  EXPECT_NEAR(huang.points[1].low, 0.1, 1e-12);
  EXPECT_NEAR(huang.points[1].high, 0.4, 1e-12);
  EXPECT_EQ(huang.points[1].samples_per_pixel, 20);
}

TEST(SummarizeScene, AWorseMethodNeverReachesTheError) {
  std::vector<ChartRow> rows;
  add_runs(rows, {.method = "none"});
  add_runs(rows, {.method = "huang", .factor = 2});
  const SceneSummary s = summarize_scene(reference_with_floor(1e-6), rows, 2);
  EXPECT_FALSE(s.methods[1].time_to_equal_error);
  EXPECT_NEAR(s.methods[1].efficiency->value, 0.5, 1e-9);
}

TEST(SummarizeScene, NothingIsClaimedAtTheFloor) {
  std::vector<ChartRow> rows;
  add_runs(rows, {.method = "none", .factor = 16});                      // ends at 1
  add_runs(rows, {.method = "huang", .factor = 1.6, .seed_spread = 4});  // at .1; .025 to .4
  const ChartReference reference = reference_with_floor(0.08);
  const SceneSummary s = summarize_scene(reference, rows, 2);
  EXPECT_TRUE(s.methods[0].efficiency);
  EXPECT_FALSE(s.methods[1].efficiency);
  EXPECT_NEAR(*s.methods[1].time_to_equal_error, 0.1, 1e-9);  // was reached well above the floor
  const std::vector<ChartPoint>& points = s.methods[1].points;
  EXPECT_FALSE(points[3].at_floor);  // .2
  EXPECT_TRUE(points[4].at_floor);
  EXPECT_EQ(points[4].low, 0.08);  // never under the floor
  EXPECT_NEAR(points[4].relmse, 0.1, 1e-12);
  EXPECT_NEAR(points[4].high, 0.4, 1e-12);

  ChartReference outside = reference_with_floor(0);
  outside.floor_known = false;
  EXPECT_TRUE(summarize_scene(outside, rows, 2).methods[1].efficiency);
}

TEST(SummarizeScene, WithoutNoneNothingIsCompared) {
  std::vector<ChartRow> rows;
  add_runs(rows, {.method = "none:nee=off"});
  add_runs(rows, {.method = "huang"});
  for (const MethodSummary& m : summarize_scene(reference_with_floor(0), rows, 2).methods) {
    EXPECT_FALSE(m.efficiency);
    EXPECT_FALSE(m.time_to_equal_error);
    EXPECT_TRUE(m.slope);
  }
}

TEST(SummarizeScene, BiasIsSeenOrAdmitted) {
  std::vector<ChartRow> rows;
  add_runs(rows, {.method = "none", .brightness = 1.001, .brightness_step = 1e-3});
  add_runs(rows, {.method = "huang", .brightness = 1.1, .brightness_step = 1e-3});
  add_runs(rows, {.method = "huang-published", .brightness_step = 1e-3});
  const SceneSummary s = summarize_scene(reference_with_floor(1e-6), rows, 3);
  EXPECT_FALSE(s.methods[0].biased);
  // Standard errors: of three runs 1e-3 / sqrt 3, of the reference 1e-3.
  EXPECT_NEAR(s.methods[0].bias_z, 1e-3 / std::hypot(1e-3 / std::sqrt(3.0), 1e-3), 1e-9);
  EXPECT_TRUE(s.methods[1].biased);
  EXPECT_TRUE(s.methods[1].unbiased);  // it claims so
  EXPECT_NEAR(s.methods[1].brightness, 1.1, 1e-12);
  EXPECT_NEAR(s.methods[2].bias_z, 0, 1e-9);
  EXPECT_TRUE(s.methods[2].biased);
}

TEST(SummarizeScene, PointsThatSomeSeedsPassedByAreLeftOut) {
  std::vector<ChartRow> rows;
  add_runs(rows, {.method = "none"});
  rows.erase(rows.begin() + 1);  // seed 1 after 2 seconds
  const auto points = summarize_scene(reference_with_floor(0), rows, 1).methods[0].points;
  ASSERT_EQ(points.size(), 4u);
  EXPECT_EQ(points[0].seconds, 1);
  EXPECT_EQ(points[1].seconds, 4);
}

TEST(SummarizeScene, ABlackSceneHasNoEfficiency) {
  std::vector<ChartRow> rows;
  add_runs(rows, {.method = "none", .factor = 0});
  const SceneSummary s = summarize_scene(reference_with_floor(0), rows, 1);
  EXPECT_FALSE(s.methods[0].efficiency);
  EXPECT_FALSE(s.methods[0].slope);
  EXPECT_FALSE(s.methods[0].biased);
}

TEST(ChartTables, SayWhatWasConcluded) {
  std::vector<ChartRow> rows;
  add_runs(rows, {.method = "none", .factor = 16});
  add_runs(rows, {.method = "huang", .factor = 4, .brightness = 1.5, .warm = true});
  add_runs(rows, {.method = "huang-published", .factor = 1.6});
  ChartSummary summary;
  summary.seconds = 16;
  summary.seeds = {1, 2, 3};
  summary.threads = 2;
  summary.scenes = {summarize_scene(reference_with_floor(0.08), rows, 3)};
  const std::string table = chart_markdown(summary);
  EXPECT_NE(table.find("## room\n\n16 s a run, 3 seeds, 8 x 8 pixels, 2 threads. Reference: 0 "
                       "samples a pixel, own relMSE 0.08.\n"),
            std::string::npos)
      << table;
  EXPECT_NE(table.find("| none | 1 | 1 [1, 1] | 1 [1, 1] | 160 | 2 | 1.000 |  |\n"),
            std::string::npos);
  EXPECT_NE(
      table.find(
          "| huang, warm | 0.25 | 4 [4, 4] | 4 [4, 4] | 160 | 2 | 1.500 | biased (z = 500.0) |\n"),
      std::string::npos)
      << table;
  EXPECT_NE(table.find("| huang-published | under 0.16 | - | - | 160 | 2 | 1.000 | biased, at the "
                       "floor |\n"),
            std::string::npos)
      << table;
  const std::string text = chart_text(summary);
  EXPECT_NE(text.find("\nroom   none             1           1 [1, 1]           1.000\n"),
            std::string::npos)
      << text;
}

}  // namespace
}  // namespace qray
