#include "core/laboratory/chart/chart_json.h"

#include <gtest/gtest.h>

#include <cmath>

namespace qray {
namespace {

ChartRow some_row() {
  ChartRow row;
  row.scene = "room \"1\"";
  row.method = "huang:grid=12";
  row.warm = true;
  row.seed = 3;
  row.point = 16;
  row.last = true;
  row.seconds = 0.1;
  row.samples_per_pixel = 1 << 20;
  row.rays = uint64_t{1} << 60;
  row.dropped_samples = 2;
  row.relmse = 1.0 / 3;
  row.relmse_trimmed = 0.25;
  row.flip = 0.125;
  row.mean_ratio = HUGE_VAL;
  row.states = 5;
  row.table_bytes = 6;
  return row;
}

TEST(ChartJson, RowsComeBackAsTheyWent) {
  const ChartRow row = some_row();
  const std::string text = chart_line(row);
  EXPECT_EQ(text.find('\n'), std::string::npos);
  const ChartRow back = std::get<ChartRow>(parse_chart_line(text).value());
  EXPECT_EQ(chart_line(back), text);
  EXPECT_EQ(back.scene, row.scene);
  EXPECT_EQ(back.rays, row.rays);
  EXPECT_EQ(back.relmse, row.relmse);
  EXPECT_EQ(back.mean_ratio, HUGE_VAL);
  EXPECT_EQ(back.point, 16);
  EXPECT_TRUE(back.warm && back.last);
  EXPECT_EQ(text,
            R"({"line":"picture","scene":"room \"1\"","method":"huang:grid=12","warm":true,)"
            R"("seed":3,"point":16,"last":true,"seconds":0.1,"samples":1048576,)"
            R"("rays":1152921504606846976,"dropped_samples":2,"relmse":0.3333333333333333,)"
            R"("relmse_trimmed":0.25,"flip":0.125,"mean_ratio":null,"states":5,"table_bytes":6})");
}

TEST(ChartJson, ReferencesAndHeadersComeBack) {
  ChartReference reference;
  reference.scene = "room";
  reference.scene_hash = "abc";
  reference.width = 3;
  reference.height = 2;
  reference.method = "none";
  reference.samples_per_pixel = 100;
  reference.seconds = 1.5;
  reference.path = "references/room.exr";
  reference.floor_relmse = 1e-5;
  reference.floor_trimmed = 1e-6;
  reference.mean_standard_error = 1e-4;
  reference.floor_known = false;
  const std::string text = chart_line(reference);
  const auto back = std::get<ChartReference>(parse_chart_line(text).value());
  EXPECT_EQ(chart_line(back), text);
  EXPECT_EQ(back.floor_relmse, 1e-5);
  EXPECT_FALSE(back.floor_known);

  const ChartHeader header{"qray chart", "0.1",   "abc",
                           "a machine",  "today", {{"--methods", "none"}, {"--size", ""}}};
  const auto header_back = std::get<ChartHeader>(parse_chart_line(chart_line(header)).value());
  EXPECT_EQ(chart_line(header_back), chart_line(header));
  EXPECT_EQ(header_back.flags, header.flags);
  EXPECT_EQ(header_back.commit, "abc");
}

TEST(ChartJson, WrongLinesNameTheField) {
  const std::string good = chart_line(some_row());
  const auto where = [](std::string text, const std::string& from, const std::string& to) {
    const size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    const auto line = parse_chart_line(text.replace(at, from.size(), to));
    return line.ok() ? "fine" : line.error().where;
  };
  EXPECT_EQ(where(good, "\"seed\":3", "\"seed\":-3"), "/seed");
  EXPECT_EQ(where(good, "\"warm\":true", "\"warm\":1"), "/warm");
  EXPECT_EQ(where(good, "\"flip\":0.125,", ""), "/flip");
  EXPECT_EQ(where(good, "picture", "pictures"), "/line");
  EXPECT_EQ(where(good, "\"scene\":\"room", "\"scene\":null,\"x\":\"room"), "/scene");
  const std::string header = chart_line(ChartHeader{"", "", "", "", "", {{"--size", "x"}}});
  EXPECT_EQ(where(header, "\"x\"", "1"), "/flags/--size");
  for (const std::string& text : {good.substr(0, good.size() / 2), std::string(), std::string("[]"),
                                  std::string(100'000, '[')})
    EXPECT_FALSE(parse_chart_line(text).ok()) << text.substr(0, 100);
}

TEST(ChartJson, SummaryHoldsWhatIsNotThereAsNull) {
  ChartSummary summary;
  summary.command = "qray chart room";
  summary.seeds = {1, 2};
  SceneSummary scene;
  scene.reference.scene = "room";
  MethodSummary m;
  m.method = "huang";
  m.efficiency = Interval{2, 1.5, 2.5};
  m.points.push_back({1, 2, 3, 4, 5, 6, 7, 8, true});
  scene.methods = {m};
  summary.scenes = {scene};
  const std::string text = chart_summary_json(summary);
  EXPECT_EQ(text.back(), '\n');
  for (const char* part :
       {"\"command\": \"qray chart room\"", "\"efficiency_trimmed\": null", "\"slope\": null",
        "\"value\": 2.0", "\"low\": 1.5", "\"at_floor\": true", "\"claims_unbiased\": true"})
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
}

}  // namespace
}  // namespace qray
