#include "core/laboratory/chart/page.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/base/file.h"
#include "core/image/difference_map.h"
#include "core/laboratory/chart/names.h"
#include "core/laboratory/chart/page_template.h"

namespace qray {
namespace {

std::string number(double value, const char* format = "%.3g") {
  char text[48];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string element(const std::string& tag, const std::string& html) {
  return "<" + tag + ">" + html + "</" + tag.substr(0, tag.find(' ')) + ">";
}

std::string label(const MethodSummary& method) {
  return html_escape(method.method) + (method.warm ? " (warm)" : "");
}

std::string badges(const MethodSummary& method) {
  if (!method.biased) return "";
  return " " + element("span class=\"badge\"",
                       std::string(method.unbiased ? "biased against its claim: " : "biased: ") +
                           brightness_words(method.brightness));
}

// An error as it may be quoted.
std::string error_text(const ChartPoint& point) {
  return number(point.relmse, "%.2g") +
         (point.at_floor ? " " + element("span class=\"badge calm\"", "at the floor") : "");
}

// A figure with the interval or the extremes below it.
std::string cell(const std::string& value, const std::string& range = "") {
  return element("td", value + (range.empty() ? "" : element("small", range)));
}
std::string cell(const std::optional<Interval>& interval) {
  if (!interval) return cell("&ndash;");
  const auto two_digits = [](double v) { return number(v, v < 100 ? "%.2g" : "%.0f"); };
  return cell(two_digits(interval->value) + "&times;",
              two_digits(interval->low) + " to " + two_digits(interval->high));
}
std::string cell(const std::optional<double>& value) {
  return cell(value ? number(*value, "%.2f") : "&ndash;");
}

std::string table_row(const MethodSummary& method) {
  std::string row = element("th scope=\"row\"", label(method) + badges(method));
  if (method.points.empty()) {
    return element("tr", row + element("td colspan=\"9\"", "no picture was made"));
  }
  const ChartPoint& last = method.points.back();
  row += cell(error_text(last), number(last.low, "%.2g") + " to " + number(last.high, "%.2g"));
  row += cell(number(last.flip, "%.3f")) + cell(number(last.samples_per_pixel, "%.0f"));
  row += cell(method.efficiency) + cell(method.efficiency_trimmed);
  row += cell(method.time_to_equal_error) + cell(method.slope);
  row += cell(number(method.brightness, "%.4f")) + cell(number(method.bias_z, "%+.1f"));
  return element("tr", row);
}

std::string table(const SceneSummary& scene) {
  std::string rows;
  for (const MethodSummary& method : scene.methods) rows += table_row(method) + "\n";
  std::string heads;
  for (const char* head :
       {"method", "error (relMSE)", "FLIP", "samples a pixel", "efficiency", "efficiency, trimmed",
        "time to equal error", "slope", "brightness", "brightness z"})
    heads += element("th scope=\"col\"", head);
  return element("div class=\"wide\" tabindex=\"0\"",
                 element("table",
                         element("thead", element("tr", heads)) + "\n" + element("tbody", rows))) +
         "\n";
}

std::string image(const std::string& kind, const std::filesystem::path& path,
                  const std::string& alt) {
  return "<img class=\"" + kind + "\" src=\"" + html_escape(path.generic_string()) + "\" alt=\"" +
         html_escape(alt) + "\">";
}

// Of the error maps.
std::string scale() {
  return element("p class=\"scale\"",
                 "<i></i>more: (x &minus; r)&sup2; / (r&sup2; + 0.01) of each pixel, " +
                     number(kErrorMapLow) + " to " + number(kErrorMapHigh));
}

// Every picture of a scene, the reference first. The script takes from here what it shows.
std::string shots(const SceneSummary& scene) {
  const std::string& name = scene.reference.scene;
  std::string figures =
      element("figure", image("picture", chart_reference_picture(name), "reference of " + name) +
                            element("figcaption", element("b", "reference")));
  for (const MethodSummary& method : scene.methods) {
    if (method.points.empty()) continue;
    const ChartPoint& last = method.points.back();
    const std::string what = method.method + (method.warm ? " (warm)" : "");
    figures +=
        "\n" +
        element("figure",
                image("picture", chart_picture(name, method.method, method.warm), what) +
                    image("error", chart_error_picture(name, method.method, method.warm),
                          "error of " + what) +
                    element("figcaption", element("b", label(method)) + badges(method) +
                                              "<br>median error " + error_text(last) + "<br>" +
                                              number(last.samples_per_pixel, "%.0f") +
                                              " samples a pixel"));
  }
  return element("div class=\"shots\"", figures + scale()) + "\n";
}

// Options in the order of shots(), counted alike.
std::string options(const SceneSummary& scene, size_t selected) {
  std::string out;
  size_t count = 0;
  const auto add = [&](const std::string& text) {
    out += "<option value=\"" + std::to_string(count) + "\"" +
           (count == selected ? " selected>" : ">") + text + "</option>";
    ++count;
  };
  add("reference");
  for (const MethodSummary& method : scene.methods)
    if (!method.points.empty()) add(label(method) + (method.biased ? ", biased" : ""));
  return out;
}

// Where the split view starts: the first method against the best of the others, in shots()' count.
size_t best_shot(const SceneSummary& scene) {
  size_t i = 0, best = 0;
  double least = INFINITY;
  for (const MethodSummary& method : scene.methods) {
    if (method.points.empty()) continue;
    const double error = method.points.back().relmse;
    if (++i == 1 || method.biased || error >= least) continue;
    best = i;
    least = error;
  }
  return best;
}

std::string choice(const std::string& words, const std::string& name, const std::string& options) {
  return element("label", words + " " + element("select class=\"" + name + "\"", options));
}

std::string compare(const SceneSummary& scene) {
  const bool any = std::any_of(scene.methods.begin(), scene.methods.end(),
                               [](const MethodSummary& method) { return !method.points.empty(); });
  const std::string size =
      std::to_string(scene.reference.width) + " / " + std::to_string(scene.reference.height);
  std::string out = "<div class=\"compare\">\n<div class=\"choose\">";
  out += choice("left", "left", options(scene, any ? 1 : 0));
  out += choice("right", "right", options(scene, best_shot(scene)));
  out += choice("show", "what",
                "<option value=\"picture\">picture</option><option value=\"error\">error "
                "map</option>");
  out += choice("zoom", "zoom",
                "<option value=\"1\">fit</option><option>2</option><option>4</option>"
                "<option>8</option>");
  out += "</div>\n<div class=\"frame\"><div class=\"stage\" style=\"aspect-ratio: " + size +
         "\"><div class=\"sheet\" style=\"aspect-ratio: " + size +
         "\"><img class=\"left\" alt=\"\"><img class=\"right\" alt=\"\"></div></div>"
         "<div class=\"handle\"></div></div>\n";
  out +=
      "<input type=\"range\" min=\"0\" max=\"100\" step=\"0.5\" value=\"50\" "
      "aria-label=\"Divider between the two pictures\">\n";
  return out +
         "<div class=\"captions\"><div class=\"left\"></div><div class=\"right\"></div></div>" +
         scale() + "\n</div>\n";
}

std::string reference_text(const ChartReference& reference) {
  std::string text =
      std::to_string(reference.width) + "&times;" + std::to_string(reference.height) + " pixels. ";
  if (!reference.floor_known) {
    return text +
           "The reference is a picture from elsewhere; its own error is not known, so the "
           "smallest errors here may be its.";
  }
  return text + "Reference: <code>" + html_escape(reference.method) + "</code>, " +
         number(static_cast<double>(reference.samples_per_pixel), "%.0f") + " samples a pixel in " +
         number(reference.seconds) + " s; its own error, the floor, is " +
         number(reference.floor_relmse, "%.2g") + ".";
}

std::string section(const SceneSummary& scene, size_t index, double seconds) {
  const std::string& name = scene.reference.scene;
  const std::string plot = chart_file_name(name) + "/chart.svg";
  return "<section class=\"scene card\" id=\"scene-" + std::to_string(index + 1) + "\">\n" +
         element("h2", html_escape(name)) + "\n" +
         element("p class=\"muted\"", reference_text(scene.reference) + " All pictures after " +
                                          number(seconds) + " s of rendering, first seed.") +
         "\n<div class=\"two\"><div class=\"plot\"><a href=\"" + plot + "\">" +
         image("curve", plot, "Error against seconds for " + name + "; figures in the table") +
         "</a></div>\n" + compare(scene) + "</div>\n" + table(scene) + shots(scene) +
         "</section>\n";
}

std::string made_by(const ChartSummary& summary) {
  std::string seeds;
  for (uint64_t seed : summary.seeds) seeds += (seeds.empty() ? "" : ", ") + std::to_string(seed);
  const auto entry = [](const std::string& term, const std::string& html) {
    return element("dt", term) + element("dd", html) + "\n";
  };
  std::string files;
  for (const char* file : {"table.md", "summary.json", "results.jsonl", "chart.svg", "chart.png",
                           "chart.dat", "chart.gp"})
    files += std::string("<a href=\"") + file + "\">" + file + "</a> ";
  return "<footer class=\"card\">\n" + element("h2", "What made it") + "\n<dl>" +
         entry("command", element("code", html_escape(summary.command))) +
         entry("commit", element("code", html_escape(summary.commit))) +
         entry("machine", html_escape(summary.machine)) +
         entry("threads", std::to_string(summary.threads)) +
         entry("date", html_escape(summary.date)) + entry("seeds", seeds) + entry("files", files) +
         "</dl>\n</footer>\n";
}

std::string page(const ChartSummary& summary) {
  std::string links, sections, names;
  for (size_t i = 0; i < summary.scenes.size(); ++i) {
    const std::string name = html_escape(summary.scenes[i].reference.scene);
    links += "<a href=\"#scene-" + std::to_string(i + 1) + "\">" + name + "</a> ";
    names += (i ? ", " : "") + name;
    sections += section(summary.scenes[i], i, summary.seconds);
  }
  return "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n" +
         element("title", "Error against time: " + names) + "\n" + element("style", kPageStyle) +
         "\n<script>document.documentElement.classList.add('js')</script>\n</head>\n<body>\n" +
         element("h1", "Error against time") + "\n" +
         element("p", "Methods that render the same picture, each with " + number(summary.seconds) +
                          " s, and how far from the truth they are.") +
         "\n" + element("nav", links) + "\n<details class=\"card\" open>" +
         element("summary", "How to read this") + kPageTerms + "</details>\n" + sections +
         made_by(summary) + element("script", kPageScript) + "\n</body>\n</html>\n";
}

}  // namespace

std::string html_escape(std::string_view text) {
  std::string out;
  for (char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string brightness_words(double ratio) {
  const double percent = 100 * std::abs(ratio - 1);
  if (ratio >= 1.5) return number(ratio, "%.2g") + " times too bright";
  if (percent < 0.05) return "as bright as the reference";
  return number(percent, percent < 10 ? "%.1f" : "%.0f") + " % too " +
         (ratio > 1 ? "bright" : "dark");
}

Status write_page(const ChartSummary& summary, const std::filesystem::path& dir) {
  const std::string html = page(summary);
  return write_file_atomic(dir / "index.html",
                           {reinterpret_cast<const uint8_t*>(html.data()), html.size()});
}

}  // namespace qray
