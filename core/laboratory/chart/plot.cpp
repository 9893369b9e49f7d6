#include "core/laboratory/chart/plot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/base/file.h"
#include "core/laboratory/chart/gnuplot.h"
#include "core/laboratory/chart/names.h"
#include "core/laboratory/chart/plot_script.h"

namespace qray {
namespace {

// What all scenes have in common: which methods there are, in order of appearance.
struct Line {
  std::string method;
  bool warm = false;
  size_t style = 0;  // the method's number, so that cold and warm look alike
};

struct Range {
  double low = INFINITY, high = 0;

  void add(double value) {
    if (!(value > 0) || !std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  void widen(double factor) { low /= factor, high *= factor; }
  bool empty() const { return low > high; }
};

std::vector<Line> series_of(const ChartSummary& summary) {
  std::vector<std::string> methods;
  std::vector<Line> all;
  for (const SceneSummary& scene : summary.scenes) {
    for (const MethodSummary& method : scene.methods) {
      auto name = std::find(methods.begin(), methods.end(), method.method);
      if (name == methods.end()) name = methods.insert(name, method.method);
      const bool known = std::any_of(all.begin(), all.end(), [&](const Line& s) {
        return s.method == method.method && s.warm == method.warm;
      });
      if (known) continue;
      all.push_back({method.method, method.warm, static_cast<size_t>(name - methods.begin())});
    }
  }
  return all;
}

const MethodSummary* find(const SceneSummary& scene, const Line& series) {
  for (const MethodSummary& method : scene.methods)
    if (method.method == series.method && method.warm == series.warm) return &method;
  return nullptr;
}

// What a logarithmic axis can show, and no further than the floor.
std::vector<ChartPoint> drawn_points(const MethodSummary& method) {
  std::vector<ChartPoint> drawn;
  for (ChartPoint point : method.points) {
    if (!(point.seconds > 0 && point.relmse > 0 && std::isfinite(point.relmse))) continue;
    if (!(point.low > 0)) point.low = point.relmse;
    if (!std::isfinite(point.high)) point.high = point.relmse;
    drawn.push_back(point);
    if (point.at_floor) break;
  }
  return drawn;
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

// A string of gnuplot. It would run what is between `s, even here.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    const bool control = static_cast<unsigned char>(c) < 0x20;
    out += control ? ' ' : c == '`' ? '\'' : c;
  }
  return out + "\"";
}

std::string array(const std::string& name, const std::vector<std::string>& values) {
  std::string out = "array " + name + "[" + std::to_string(values.size()) + "] = [";
  for (size_t i = 0; i < values.size(); ++i) out += (i ? ", \\\n  " : "") + values[i];
  return out + "]\n";
}

// A comment of one line.
std::string comment(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return "# " + text + "\n";
}

std::string data_text(const ChartSummary& summary, const std::vector<Line>& series) {
  std::string out = comment(summary.command);
  out += "# Medians over seeds, with the least and the greatest; a line ends at its floor.\n";
  out += "# 1 scene, 2 series, 3 seconds, 4 relMSE, 5 least, 6 greatest, 7 samples a pixel,\n";
  out += "# 8 relMSE trimmed, 9 FLIP\n";
  for (size_t s = 0; s < summary.scenes.size(); ++s) {
    for (size_t i = 0; i < series.size(); ++i) {
      const MethodSummary* method = find(summary.scenes[s], series[i]);
      if (method == nullptr) continue;
      out += "\n" + comment(summary.scenes[s].reference.scene + ": " + method->method +
                            (method->warm ? ", warm" : ""));
      for (const ChartPoint& p : drawn_points(*method)) {
        out += std::to_string(s + 1) + " " + std::to_string(i + 1);
        for (double v :
             {p.seconds, p.relmse, p.low, p.high, p.samples_per_pixel, p.relmse_trimmed, p.flip})
          out += " " + number(v);
        out += "\n";
      }
    }
  }
  return out;
}

// The legend's text of a series, over all scenes in which it is.
std::string label(const Line& series, const std::vector<SceneSummary>& scenes) {
  size_t present = 0, biased = 0;
  for (const SceneSummary& scene : scenes) {
    const MethodSummary* method = find(scene, series);
    present += method != nullptr;
    biased += method != nullptr && method->biased;
  }
  if (present == 0) return "";
  std::string text = series.method + (series.warm ? " (warm)" : "");
  if (biased == 0) return text;
  if (biased == present) return text + ", biased";
  return text + ", biased in " + std::to_string(biased) + " of " + std::to_string(present) +
         " scenes";
}

// How the lines are to be read.
std::string note(const ChartSummary& summary) {
  bool biased = false, warm = false;
  for (const SceneSummary& scene : summary.scenes)
    for (const MethodSummary& method : scene.methods) {
      biased |= method.biased;
      warm |= method.warm;
    }
  const size_t seeds = summary.seeds.size();
  std::string text = "line: median of " + std::to_string(seeds) + " seeds; band: least to greatest";
  if (seeds == 1) text = "line: one seed";
  return text + (biased ? "; dashed: biased" : "") + (warm ? "; hollow: warm" : "");
}

Range error_range(const SceneSummary& scene) {
  Range range;
  for (const MethodSummary& method : scene.methods)
    for (const ChartPoint& point : drawn_points(method))
      for (double error : {point.low, point.relmse, point.high}) range.add(error);
  if (range.empty()) range = {1e-4, 1};
  range.widen(1.3);
  return range;
}

// How each line looks. Okabe and Ito's palette without its yellow, told apart by colour-blind
// readers; the points, six shapes, filled or (warm) hollow, tell lines apart in grey.
std::string line_definitions(const std::vector<Line>& series) {
  static constexpr const char* kColours[] = {"0x000000", "0xe69f00", "0x0072b2", "0x009e73",
                                             "0xd55e00", "0xcc79a7", "0x56b4e9", "0x7f7f7f"};
  std::vector<std::string> colour, point;
  for (const Line& s : series) {
    colour.push_back(kColours[s.style % std::size(kColours)]);
    point.push_back(std::to_string(5 + 2 * ((s.style + 1) % 6) - (s.warm ? 1 : 0)));
  }
  return array("colour", colour) + array("point", point);
}

std::string scene_definitions(const std::vector<SceneSummary>& scenes) {
  std::vector<std::string> title, folder, floor, low, high;
  Range seconds;
  for (const SceneSummary& scene : scenes) {
    for (const MethodSummary& method : scene.methods)
      for (const ChartPoint& point : drawn_points(method)) seconds.add(point.seconds);
    const ChartReference& reference = scene.reference;
    title.push_back(quoted(reference.scene));
    folder.push_back(quoted(chart_file_name(reference.scene)));
    Range error = error_range(scene);
    const bool near = reference.floor_known && reference.floor_relmse > error.low / 30;
    if (near) error.low = std::min(error.low, reference.floor_relmse);
    error.low /= std::pow(error.high / error.low, 0.1);  // a tenth of the height for words
    floor.push_back(reference.floor_known ? number(reference.floor_relmse) : "-1");
    low.push_back(number(error.low)), high.push_back(number(error.high));
  }
  if (seconds.empty()) seconds = {0.1, 10};
  seconds.widen(1.15);
  return "x_low = " + number(seconds.low) + "\nx_high = " + number(seconds.high) + "\n" +
         array("title", title) + array("folder", folder) + array("floor", floor) +
         array("low", low) + array("high", high);
}

// The columns of a legend that gnuplot will fit: it takes a letter for 9.1 pixels wide.
std::string legend_columns(int width_px, const std::vector<std::string>& labels) {
  size_t longest = 1;
  for (const std::string& text : labels) longest = std::max(longest, text.size());
  return std::to_string(std::max(1, static_cast<int>(width_px / 9.1 / (longest + 6.0))));
}

std::string legend_definitions(const std::vector<SceneSummary>& scenes,
                               const std::vector<Line>& series, int panel_columns) {
  std::vector<std::string> all, one, dash;
  for (const Line& s : series) all.push_back(quoted(label(s, scenes)));
  for (const SceneSummary& scene : scenes)
    for (const Line& s : series) {
      const MethodSummary* method = find(scene, s);
      one.push_back(quoted(label(s, {scene})));
      dash.push_back(method != nullptr && method->biased ? "2" : "1");
    }
  const int all_px = panel_columns == 1 ? 640 : 480 * panel_columns;
  const std::string columns = "legend_columns_all = " + legend_columns(all_px, all) +
                              "\nlegend_columns_one = " + legend_columns(640, one) + "\n";
  all.insert(all.end(), one.begin(), one.end());
  return columns +
         "# Over all scenes, then scene by scene; empty where a scene has no such series.\n" +
         array("label", all) + array("dash", dash);
}

// What kPlotScript asks for.
std::string definitions(const ChartSummary& summary, const std::vector<Line>& series) {
  const size_t scenes = summary.scenes.size();
  const int columns = scenes < 5 ? std::min(static_cast<int>(scenes), 2) : 3;
  return "all_columns = " + std::to_string(columns) + "\nnote = " + quoted(note(summary)) + "\n" +
         line_definitions(series) + scene_definitions(summary.scenes) +
         legend_definitions(summary.scenes, series, columns);
}

Status write(const std::filesystem::path& path, const std::string& text) {
  return write_file_atomic(path, {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

}  // namespace

Status write_plots(const ChartSummary& summary, const std::filesystem::path& dir) {
  const std::vector<Line> series = series_of(summary);
  if (series.empty()) {
    return Error{ErrorCode::kInvalid, "nothing to draw: expected a scene with a method",
                 dir.string()};
  }
  for (const SceneSummary& scene : summary.scenes) {
    const std::filesystem::path folder = dir / chart_file_name(scene.reference.scene);
    std::error_code failure;
    std::filesystem::create_directories(folder, failure);
    if (failure) {
      return Error{ErrorCode::kIo, "cannot make: " + failure.message(), folder.string()};
    }
  }
  const Status data = write(dir / "chart.dat", data_text(summary, series));
  if (!data) return data;
  const std::string head = "# Draws chart.svg, chart.png and each scene's: gnuplot chart.gp\n";
  const Status script = write(dir / "chart.gp", head + definitions(summary, series) + kPlotScript);
  if (!script) return script;
  return run_gnuplot(dir, "chart.gp");
}

}  // namespace qray
