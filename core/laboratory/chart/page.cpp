#include "core/laboratory/chart/page.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/base/file.h"
#include "core/image/difference_map.h"
#include "core/laboratory/chart/html_template.h"
#include "core/laboratory/chart/names.h"

// page.html, as it stands, in the program.
asm(".pushsection .rodata\n"
    "qray_chart_page_begin:\n"
    ".incbin \"" QRAY_CHART_PAGE
    "\"\n"
    "qray_chart_page_end:\n"
    ".popsection\n");
extern "C" {
extern const char kChartPageBegin[] asm("qray_chart_page_begin");
extern const char kChartPageEnd[] asm("qray_chart_page_end");
}

namespace qray {
namespace {

std::string number(double value, const char* format = "%.3g") {
  char text[48];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string label(const MethodSummary& method) {
  return method.method + (method.warm ? " (warm)" : "");
}

// A figure of the table with the interval or the extremes below it.
HtmlData cell(const std::string& value, const std::string& range = "", bool at_floor = false) {
  HtmlData data;
  data.texts["value"] = value;
  data.show_if("at_floor", at_floor);
  data.show_if("range", !range.empty(), {.texts = {{"text", range}}, .lists = {}});
  return data;
}
HtmlData cell(const std::optional<Interval>& interval) {
  if (!interval) return cell("–");
  const auto two_digits = [](double v) { return number(v, v < 100 ? "%.2g" : "%.0f"); };
  return cell(two_digits(interval->value) + "×",
              two_digits(interval->low) + " to " + two_digits(interval->high));
}
HtmlData cell(const std::optional<double>& value) {
  return cell(value ? number(*value, "%.2f") : "–");
}

// What the row of the table and the picture's caption have in common.
HtmlData method_data(const MethodSummary& method) {
  HtmlData data;
  data.texts["label"] = label(method);
  const std::string words =
      std::string(method.unbiased ? "biased against its claim: " : "biased: ") +
      brightness_words(method.brightness);
  data.show_if("biased", method.biased, {.texts = {{"words", words}}, .lists = {}});
  return data;
}

HtmlData table_row(const MethodSummary& method) {
  HtmlData row = method_data(method);
  std::vector<HtmlData>& cells = row.lists["cells"];
  if (method.points.empty()) return row;
  const ChartPoint& last = method.points.back();
  cells = {cell(number(last.relmse, "%.2g"),
                number(last.low, "%.2g") + " to " + number(last.high, "%.2g"), last.at_floor),
           cell(number(last.flip, "%.3f")),
           cell(number(last.samples_per_pixel, "%.0f")),
           cell(method.efficiency),
           cell(method.efficiency_trimmed),
           cell(method.time_to_equal_error),
           cell(method.slope),
           cell(number(method.brightness, "%.4f")),
           cell(number(method.bias_z, "%+.1f"))};
  return row;
}

HtmlData shot(const std::string& scene, const MethodSummary& method) {
  HtmlData data = method_data(method);
  const ChartPoint& last = method.points.back();
  data.texts["picture"] = chart_picture(scene, method.method, method.warm).generic_string();
  data.texts["error_picture"] =
      chart_error_picture(scene, method.method, method.warm).generic_string();
  data.texts["error"] = number(last.relmse, "%.2g");
  data.texts["samples"] = number(last.samples_per_pixel, "%.0f");
  data.show_if("at_floor", last.at_floor);
  return data;
}

// Of the split view, which counts the shots: 0 is the reference, then every method with a picture.
std::vector<HtmlData> options(const std::vector<const MethodSummary*>& shown, size_t selected) {
  std::vector<HtmlData> list;
  const auto add = [&](const std::string& text) {
    HtmlData& option = list.emplace_back();
    option.texts = {{"shot", std::to_string(list.size() - 1)}, {"text", text}};
    option.show_if("selected", list.size() - 1 == selected);
  };
  add("reference");
  for (const MethodSummary* method : shown)
    add(label(*method) + (method->biased ? ", biased" : ""));
  return list;
}

// Where the split view starts: the first method against the best of the others.
size_t best_shot(const std::vector<const MethodSummary*>& shown) {
  size_t best = 0;
  double least = INFINITY;
  for (size_t i = 1; i < shown.size(); ++i) {
    const double error = shown[i]->points.back().relmse;
    if (shown[i]->biased || error >= least) continue;
    best = i + 1;
    least = error;
  }
  return best;
}

HtmlData scene_data(const SceneSummary& scene, size_t index) {
  const ChartReference& reference = scene.reference;
  HtmlData data;
  data.texts = {{"number", std::to_string(index + 1)},
                {"name", reference.scene},
                {"width", std::to_string(reference.width)},
                {"height", std::to_string(reference.height)},
                {"plot", chart_file_name(reference.scene) + "/chart.svg"},
                {"reference_picture", chart_reference_picture(reference.scene).generic_string()}};
  const double samples = static_cast<double>(reference.samples_per_pixel);
  data.show_if("own_reference", reference.floor_known,
               {.texts = {{"method", reference.method},
                          {"samples", number(samples, "%.0f")},
                          {"time", number(reference.seconds)},
                          {"floor", number(reference.floor_relmse, "%.2g")}},
                .lists = {}});
  std::vector<const MethodSummary*> shown;
  std::vector<HtmlData>&rows = data.lists["methods"], &shots = data.lists["shots"];
  for (const MethodSummary& method : scene.methods) {
    rows.push_back(table_row(method));
    if (method.points.empty()) continue;
    shown.push_back(&method);
    shots.push_back(shot(reference.scene, method));
  }
  data.lists["left_options"] = options(shown, shown.empty() ? 0 : 1);
  data.lists["right_options"] = options(shown, best_shot(shown));
  return data;
}

HtmlData page_data(const ChartSummary& summary) {
  HtmlData data;
  std::string names, seeds;
  for (uint64_t seed : summary.seeds) seeds += (seeds.empty() ? "" : ", ") + std::to_string(seed);
  std::vector<HtmlData>& scenes = data.lists["scenes"];
  for (const SceneSummary& scene : summary.scenes) {
    names += (names.empty() ? "" : ", ") + scene.reference.scene;
    scenes.push_back(scene_data(scene, scenes.size()));
  }
  data.texts = {{"names", names},
                {"seconds", number(summary.seconds)},
                {"error_map_low", number(kErrorMapLow)},
                {"error_map_high", number(kErrorMapHigh)},
                {"command", summary.command},
                {"commit", summary.commit},
                {"machine", summary.machine},
                {"threads", std::to_string(summary.threads)},
                {"date", summary.date},
                {"seeds", seeds}};
  return data;
}

}  // namespace

std::string brightness_words(double ratio) {
  const double percent = 100 * std::abs(ratio - 1);
  if (ratio >= 1.5) return number(ratio, "%.2g") + " times too bright";
  if (percent < 0.05) return "as bright as the reference";
  return number(percent, percent < 10 ? "%.1f" : "%.0f") + " % too " +
         (ratio > 1 ? "bright" : "dark");
}

Status write_page(const ChartSummary& summary, const std::filesystem::path& dir) {
  const std::string html = fill_html(
      {kChartPageBegin, static_cast<size_t>(kChartPageEnd - kChartPageBegin)}, page_data(summary));
  return write_file_atomic(dir / "index.html",
                           {reinterpret_cast<const uint8_t*>(html.data()), html.size()});
}

}  // namespace qray
