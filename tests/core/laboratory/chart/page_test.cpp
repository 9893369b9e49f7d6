// The page of a chart: what it says of constructed summaries, and that it needs nothing from
// elsewhere. How it behaves in a browser: tests/e2e/chart_page_test.mjs.
#include "core/laboratory/chart/page.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <regex>

#include "core/base/file.h"
#include "core/laboratory/chart/names.h"
#include "tests/core/laboratory/chart/made_up_summary.h"
#include "tests/support/scratch.h"

namespace qray {
namespace {

std::string page_of(const ChartSummary& summary) {
  const test::ScratchFolder folder;
  const Status written = write_page(summary, folder.path());
  EXPECT_TRUE(written.ok()) << written.error().text();
  const Result<Bytes> bytes = read_file(folder / "index.html", 1 << 24);
  EXPECT_TRUE(bytes.ok());
  return bytes.ok() ? std::string(bytes.value().begin(), bytes.value().end()) : "";
}

bool has(const std::string& html, const std::string& part) {
  return html.find(part) != std::string::npos;
}

// The row of a method in the table of the only scene that has it.
std::string row_of(const std::string& html, const std::string& method) {
  const size_t at = html.find("<tr><th scope=\"row\">" + method);
  return at == std::string::npos ? "" : html.substr(at, html.find("</tr>", at) - at);
}

// What the page asks a browser for, and where its links lead.
std::vector<std::string> addresses(const std::string& html) {
  const std::regex attribute("(?:src|href)=\"([^\"]*)\"");
  std::vector<std::string> all;
  for (std::sregex_iterator it(html.begin(), html.end(), attribute), end; it != end; ++it)
    all.push_back((*it)[1]);
  return all;
}

TEST(ChartPage, HtmlEscapeLeavesNoMarkup) {
  EXPECT_EQ(html_escape("a<b>&\"c\"'"), "a&lt;b&gt;&amp;&quot;c&quot;&#39;");
  EXPECT_EQ(html_escape("huang:grid=12"), "huang:grid=12");
}

TEST(ChartPage, BrightnessInWords) {
  EXPECT_EQ(brightness_words(2.84), "2.8 times too bright");
  EXPECT_EQ(brightness_words(1.04), "4.0 % too bright");
  EXPECT_EQ(brightness_words(0.996), "0.4 % too dark");
  EXPECT_EQ(brightness_words(0.25), "75 % too dark");
  EXPECT_EQ(brightness_words(1.0001), "as bright as the reference");
}

TEST(ChartPage, EveryNameFromOutsideIsEscaped) {
  const std::string nasty = "<script>alert('x')</script>\"&";
  ChartSummary summary = test::made_up_summary();
  summary.command = summary.commit = summary.machine = summary.date = nasty;
  ChartReference& reference = summary.scenes[0].reference;
  reference.scene = reference.method = reference.path = nasty;
  for (MethodSummary& method : summary.scenes[0].methods) method.method = nasty;
  const std::string html = page_of(summary);
  EXPECT_FALSE(has(html, "<script>alert"));
  EXPECT_FALSE(has(html, "alert('"));
  const std::string safe = html_escape(nasty);
  for (const std::string& place :
       {"<h2>" + safe + "</h2>", "<dd><code>" + safe + "</code></dd>", "<dd>" + safe + "</dd>",
        "<th scope=\"row\">" + safe, "alt=\"" + safe + "\""})
    EXPECT_TRUE(has(html, place)) << place;
}

TEST(ChartPage, BadgesSayHowFarABiasedMethodIsOff) {
  ChartSummary summary = test::made_up_summary();
  std::vector<MethodSummary>& methods = summary.scenes[0].methods;
  methods[1].brightness = 2.76;
  methods[2].biased = true;  // though it claims not to be
  methods[2].brightness = 0.97;
  const std::string html = page_of(summary);
  EXPECT_FALSE(has(row_of(html, "none"), "badge"));
  EXPECT_TRUE(has(row_of(html, "huang-published"), ">biased: 2.8 times too bright<"));
  EXPECT_TRUE(has(row_of(html, "huang <"), ">biased against its claim: 3.0 % too dark<")) << html;
}

TEST(ChartPage, AnErrorAtTheFloorSaysSo) {
  const std::string html = page_of(test::made_up_summary());
  EXPECT_TRUE(has(html, "the floor, is 0.0002."));
  EXPECT_TRUE(has(row_of(html, "huang<"), "0.0002 <span class=\"badge calm\">at the floor<"));
  EXPECT_FALSE(has(row_of(html, "none"), "at the floor"));
  ChartSummary summary = test::made_up_summary();
  summary.scenes[0].reference.floor_known = false;
  EXPECT_TRUE(has(page_of(summary), "its own error is not known"));
}

TEST(ChartPage, FiguresThatAreNotThereAreDashes) {
  ChartSummary summary = test::made_up_summary();
  MethodSummary& method = summary.scenes[0].methods[2];
  EXPECT_TRUE(has(row_of(page_of(summary), "huang<"), "<td>5&times;<small>4 to 6</small></td>"));
  method.efficiency.reset(), method.efficiency_trimmed.reset();
  method.time_to_equal_error.reset(), method.slope.reset();
  const std::string row = row_of(page_of(summary), "huang<");
  EXPECT_TRUE(has(row, "<td>&ndash;</td><td>&ndash;</td><td>&ndash;</td><td>&ndash;</td>")) << row;
  method.points.clear();
  const std::string html = page_of(summary);
  EXPECT_TRUE(has(row_of(html, "huang<"), "no picture was made"));
  EXPECT_FALSE(has(html, "ajar-door/huang.png"));
}

TEST(ChartPage, AsksOnlyForFilesOfItsFolder) {
  ChartSummary summary = test::made_up_summary();
  summary.scenes.push_back(test::made_up_scene("Lamp room", 1e-4));
  summary.scenes[1].methods[2].warm = true;
  const std::string html = page_of(summary);
  std::vector<std::string> expected;
  for (const SceneSummary& scene : summary.scenes) {
    const std::string& name = scene.reference.scene;
    expected.push_back(chart_reference_picture(name).string());
    expected.push_back(chart_file_name(name) + "/chart.svg");
    expected.push_back(chart_file_name(name) + "/chart.svg");  // the link around the picture
    for (const MethodSummary& method : scene.methods) {
      expected.push_back(chart_picture(name, method.method, method.warm).string());
      expected.push_back(chart_error_picture(name, method.method, method.warm).string());
    }
  }
  for (const char* file : {"#scene-1", "#scene-2", "table.md", "summary.json", "results.jsonl",
                           "chart.svg", "chart.png", "chart.dat", "chart.gp"})
    expected.push_back(file);
  std::vector<std::string> asked = addresses(html);
  std::sort(asked.begin(), asked.end());
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(asked, expected);
  for (const char* outside : {"http:", "https:", "url(", "@import", "fetch("})
    EXPECT_FALSE(has(html, outside)) << outside;
}

TEST(ChartPage, BeginsWithTheFirstMethodAgainstTheBestUnbiasedOne) {
  ChartSummary summary = test::made_up_summary();
  summary.scenes[0].methods[1].points.back().relmse = 1e-9;  // biased: not the best
  const std::string html = page_of(summary);
  EXPECT_TRUE(has(html, "<option value=\"1\" selected>none</option>"));
  EXPECT_TRUE(has(html, "<option value=\"3\" selected>huang</option>"));
  EXPECT_TRUE(has(html, "<option value=\"2\">huang-published, biased</option>"));
  summary.scenes[0].methods.resize(1);  // against the reference
  EXPECT_TRUE(has(page_of(summary), "<option value=\"0\" selected>reference</option>"));
}

}  // namespace
}  // namespace qray
