#include "core/laboratory/chart/summarize.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/laboratory/chart/statistics.h"
#include "core/settings/variant.h"

namespace qray {
namespace {

using Rows = std::vector<const ChartRow*>;

struct Series {
  std::string method;
  bool warm = false;
  std::map<int, Rows> by_point;
  Rows last;  // one a seed, by seed
};

std::vector<Series> split(std::span<const ChartRow> rows) {
  std::vector<Series> all;
  for (const ChartRow& row : rows) {
    auto it = std::find_if(all.begin(), all.end(), [&](const Series& s) {
      return s.method == row.method && s.warm == row.warm;
    });
    if (it == all.end()) it = all.insert(all.end(), Series{row.method, row.warm, {}, {}});
    it->by_point[row.point].push_back(&row);
    if (row.last) it->last.push_back(&row);
  }
  for (Series& s : all)
    std::sort(s.last.begin(), s.last.end(),
              [](const ChartRow* a, const ChartRow* b) { return a->seed < b->seed; });
  return all;
}

template <class Field>
std::vector<double> values(const Rows& rows, Field field) {
  std::vector<double> out;
  for (const ChartRow* row : rows) out.push_back(static_cast<double>(row->*field));
  return out;
}

bool at_floor(double error, double floor, bool known) {
  return error <= 0 || (known && error < kFloorFactor * floor);
}

ChartPoint point_of(const Rows& rows, const ChartReference& reference) {
  const std::vector<double> errors = values(rows, &ChartRow::relmse);
  const double floor = reference.floor_relmse;
  ChartPoint p;
  p.seconds = median(values(rows, &ChartRow::seconds));
  p.samples_per_pixel = median(values(rows, &ChartRow::samples_per_pixel));
  p.relmse = std::max(median(errors), floor);
  p.low = std::max(*std::min_element(errors.begin(), errors.end()), floor);
  p.high = std::max(*std::max_element(errors.begin(), errors.end()), floor);
  p.relmse_trimmed =
      std::max(median(values(rows, &ChartRow::relmse_trimmed)), reference.floor_trimmed);
  p.flip = median(values(rows, &ChartRow::flip));
  p.table_bytes = median(values(rows, &ChartRow::table_bytes));
  p.at_floor = at_floor(p.relmse, floor, reference.floor_known);
  return p;
}

// 1/(error x seconds) of `rows` over that of `base`, where both ran a seed. None at the floor.
std::optional<Interval> efficiency(const Rows& rows, const Rows& base, double ChartRow::*error,
                                   double floor, bool floor_known) {
  for (const Rows* side : {&rows, &base})
    if (at_floor(median(values(*side, error)), floor, floor_known)) return std::nullopt;
  std::vector<double> logs;
  for (const ChartRow* row : rows)
    for (const ChartRow* other : base)
      if (row->seed == other->seed)
        logs.push_back(std::log(other->*error * other->seconds / (row->*error * row->seconds)));
  if (logs.size() < 2) return std::nullopt;
  return ratio_interval(logs);
}

std::vector<std::pair<double, double>> error_curve(std::span<const ChartPoint> points) {
  std::vector<std::pair<double, double>> curve;
  for (const ChartPoint& p : points) curve.emplace_back(p.seconds, p.relmse);
  return curve;
}

std::optional<double> late_slope(std::span<const ChartPoint> points) {
  std::vector<std::pair<double, double>> late;
  for (const ChartPoint& p : points.subspan(points.size() / 2))
    if (!p.at_floor) late.emplace_back(p.seconds, p.relmse);
  return late.size() >= 3 ? std::optional(log_slope(late)) : std::nullopt;
}

MethodSummary summarize(const Series& series, const ChartReference& reference, int all_series) {
  MethodSummary m;
  m.method = series.method;
  m.warm = series.warm;
  m.unbiased = method_traits(series.method).unbiased;
  m.seeds = static_cast<int>(series.last.size());
  for (const auto& [point, rows] : series.by_point)
    if (rows.size() == series.last.size()) m.points.push_back(point_of(rows, reference));
  m.slope = late_slope(m.points);
  const std::vector<double> brightness = values(series.last, &ChartRow::mean_ratio);
  m.brightness = mean(brightness);
  m.bias_z = bias_score(brightness, reference.mean_standard_error);
  const double limit = student_quantile(1 - kBiasAlarm / 2 / all_series, m.seeds - 1);
  m.biased = !m.unbiased || std::abs(m.bias_z) > limit;
  return m;
}

}  // namespace

SceneSummary summarize_scene(const ChartReference& reference, std::span<const ChartRow> rows,
                             int series) {
  SceneSummary scene;
  scene.reference = reference;
  const std::vector<Series> all = split(rows);
  const auto is_base = [](const auto& s) { return s.method == "none" && !s.warm; };
  for (const Series& s : all) scene.methods.push_back(summarize(s, reference, series));

  const auto base = std::find_if(all.begin(), all.end(), is_base);
  if (base == all.end()) return scene;
  const ChartPoint end = scene.methods[static_cast<size_t>(base - all.begin())].points.back();
  for (size_t i = 0; i < all.size(); ++i) {
    MethodSummary& m = scene.methods[i];
    const auto over_base = [&](double ChartRow::*error, double floor) {
      return efficiency(all[i].last, base->last, error, floor, reference.floor_known);
    };
    m.efficiency = over_base(&ChartRow::relmse, reference.floor_relmse);
    m.efficiency_trimmed = over_base(&ChartRow::relmse_trimmed, reference.floor_trimmed);
    if (end.at_floor) continue;
    if (const auto seconds = last_crossing(error_curve(m.points), end.relmse))
      m.time_to_equal_error = *seconds / end.seconds;
  }
  return scene;
}

}  // namespace qray
