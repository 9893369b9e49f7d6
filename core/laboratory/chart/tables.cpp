#include "core/laboratory/chart/tables.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <vector>

#include "core/laboratory/chart/summarize.h"

namespace qray {
namespace {

template <class... Args>
std::string format(const char* pattern, Args... args) {
  char text[128];
  std::snprintf(text, sizeof text, pattern, args...);
  return text;
}

std::string name_of(const MethodSummary& m) { return m.method + (m.warm ? ", warm" : ""); }

std::string error_text(const ChartPoint& end, const ChartReference& reference) {
  if (!end.at_floor) return format("%.3g", end.relmse);
  return format("under %.2g", kFloorFactor * reference.floor_relmse);
}
std::string efficiency_text(const std::optional<Interval>& e) {
  return e ? format("%.3g [%.3g, %.3g]", e->value, e->low, e->high) : "-";
}
std::string note_of(const MethodSummary& m) {
  std::string note =
      m.biased ? (m.unbiased ? format("biased (z = %.1f)", m.bias_z) : "biased") : "";
  if (m.points.back().at_floor) note += (note.empty() ? "" : ", ") + std::string("at the floor");
  return note;
}

}  // namespace

std::string chart_markdown(const ChartSummary& summary) {
  std::string out;
  for (const SceneSummary& scene : summary.scenes) {
    const ChartReference& r = scene.reference;
    out += (out.empty() ? "## " : "\n## ") + r.scene + "\n\n";
    out += format("%.3g s a run, %zu seeds, %d x %d pixels, %d threads. ", summary.seconds,
                  summary.seeds.size(), r.width, r.height, summary.threads);
    out += r.floor_known
               ? format("Reference: %llu samples a pixel, own relMSE %.2g.\n\n",
                        static_cast<unsigned long long>(r.samples_per_pixel), r.floor_relmse)
               : "The reference's own error is not known.\n\n";
    out +=
        "| method | relMSE | efficiency over none | the same, trimmed | samples/px | table KiB "
        "| brightness | note |\n"
        "|---|--:|--:|--:|--:|--:|--:|---|\n";
    for (const MethodSummary& m : scene.methods) {
      const ChartPoint& end = m.points.back();
      out +=
          "| " + name_of(m) + " | " + error_text(end, r) + " | " + efficiency_text(m.efficiency) +
          " | " + efficiency_text(m.efficiency_trimmed) + format(" | %.0f", end.samples_per_pixel) +
          format(" | %.0f | %.3f | ", end.table_bytes / 1024, m.brightness) + note_of(m) + " |\n";
    }
  }
  return out;
}

std::string chart_text(const ChartSummary& summary) {
  constexpr size_t kColumns = 6;
  using Line = std::array<std::string, kColumns>;
  std::vector<Line> lines{{"scene", "method", "relMSE", "efficiency [95 %]", "brightness", ""}};
  for (const SceneSummary& scene : summary.scenes)
    for (const MethodSummary& m : scene.methods)
      lines.push_back({scene.reference.scene, name_of(m),
                       error_text(m.points.back(), scene.reference), efficiency_text(m.efficiency),
                       format("%.3f", m.brightness), note_of(m)});
  std::array<size_t, kColumns> widths{};
  for (const Line& line : lines)
    for (size_t i = 0; i < kColumns; ++i) widths[i] = std::max(widths[i], line[i].size());
  std::string out;
  for (const Line& line : lines) {
    std::string text;
    for (size_t i = 0; i < kColumns; ++i)
      text += line[i] + std::string(widths[i] - line[i].size() + 2, ' ');
    text.erase(text.find_last_not_of(' ') + 1);
    out += text + "\n";
  }
  return out;
}

}  // namespace qray
