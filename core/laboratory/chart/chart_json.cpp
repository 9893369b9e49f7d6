#include "core/laboratory/chart/chart_json.h"

#include <limits>
#include <nlohmann/json.hpp>

namespace qray {
namespace {

using nlohmann::ordered_json;

// One list of fields for writing and for reading each kind of line: visit(name, member).
template <class Header, class Visit>
void header_fields(Header& h, Visit visit) {
  visit("command", h.command);
  visit("program", h.program);
  visit("commit", h.commit);
  visit("machine", h.machine);
  visit("date", h.date);
}
template <class Reference, class Visit>
void reference_fields(Reference& r, Visit visit) {
  visit("scene", r.scene);
  visit("scene_hash", r.scene_hash);
  visit("width", r.width);
  visit("height", r.height);
  visit("method", r.method);
  visit("samples", r.samples_per_pixel);
  visit("seconds", r.seconds);
  visit("path", r.path);
  visit("floor_known", r.floor_known);
  visit("floor_relmse", r.floor_relmse);
  visit("floor_trimmed", r.floor_trimmed);
  visit("mean_standard_error", r.mean_standard_error);
}
template <class Row, class Visit>
void row_fields(Row& r, Visit visit) {
  visit("scene", r.scene);
  visit("method", r.method);
  visit("warm", r.warm);
  visit("seed", r.seed);
  visit("point", r.point);
  visit("last", r.last);
  visit("seconds", r.seconds);
  visit("samples", r.samples_per_pixel);
  visit("rays", r.rays);
  visit("dropped_samples", r.dropped_samples);
  visit("relmse", r.relmse);
  visit("relmse_trimmed", r.relmse_trimmed);
  visit("flip", r.flip);
  visit("mean_ratio", r.mean_ratio);
  visit("states", r.states);
  visit("table_bytes", r.table_bytes);
}

struct Writer {
  ordered_json& object;
  template <class T>
  void operator()(const char* name, const T& value) const {
    object[name] = value;
  }
};

// Reads fields of an object; keeps the first that is missing or of another type.
struct Reader {
  const ordered_json& object;
  std::string& wrong;

  void operator()(const char* name, std::string& out) const {
    read(name, out, &ordered_json::is_string);
  }
  void operator()(const char* name, bool& out) const { read(name, out, &ordered_json::is_boolean); }
  void operator()(const char* name, int& out) const {
    read(name, out, &ordered_json::is_number_unsigned);
  }
  void operator()(const char* name, uint64_t& out) const {
    read(name, out, &ordered_json::is_number_unsigned);
  }
  void operator()(const char* name, double& out) const {
    if (const auto it = object.find(name); it != object.end() && it->is_null())
      out = std::numeric_limits<double>::infinity();
    else
      read(name, out, &ordered_json::is_number);
  }

 private:
  template <class T, class Is>
  void read(const char* name, T& out, Is is) const {
    if (const auto it = object.find(name); it != object.end() && ((*it).*is)())
      out = it->template get<T>();
    else if (wrong.empty())
      wrong = std::string("/") + name;
  }
};

std::string line_of(const ordered_json& object) {
  return object.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

Error not_a_line(const std::string& pointer) {
  return {ErrorCode::kInvalid, "expected a line of a chart's results", pointer};
}

ordered_json interval_json(const std::optional<Interval>& i) {
  if (!i) return nullptr;
  return {{"value", i->value}, {"low", i->low}, {"high", i->high}};
}
ordered_json optional_json(const std::optional<double>& v) {
  return v ? ordered_json(*v) : ordered_json(nullptr);
}

ordered_json method_json(const MethodSummary& m) {
  ordered_json points = ordered_json::array();
  for (const ChartPoint& p : m.points)
    points.push_back({{"seconds", p.seconds},
                      {"samples", p.samples_per_pixel},
                      {"relmse", p.relmse},
                      {"low", p.low},
                      {"high", p.high},
                      {"relmse_trimmed", p.relmse_trimmed},
                      {"flip", p.flip},
                      {"table_bytes", p.table_bytes},
                      {"at_floor", p.at_floor}});
  return {{"method", m.method},
          {"warm", m.warm},
          {"claims_unbiased", m.unbiased},
          {"seeds", m.seeds},
          {"efficiency", interval_json(m.efficiency)},
          {"efficiency_trimmed", interval_json(m.efficiency_trimmed)},
          {"time_to_equal_error", optional_json(m.time_to_equal_error)},
          {"slope", optional_json(m.slope)},
          {"brightness", m.brightness},
          {"bias_z", m.bias_z},
          {"biased", m.biased},
          {"points", std::move(points)}};
}

}  // namespace

std::string chart_line(const ChartHeader& header) {
  ordered_json object = {{"line", "header"}};
  header_fields(header, Writer{object});
  ordered_json& flags = object["flags"] = ordered_json::object();
  for (const auto& [name, value] : header.flags) flags[name] = value;
  return line_of(object);
}

std::string chart_line(const ChartReference& reference) {
  ordered_json object = {{"line", "reference"}};
  reference_fields(reference, Writer{object});
  return line_of(object);
}

std::string chart_line(const ChartRow& row) {
  ordered_json object = {{"line", "picture"}};
  row_fields(row, Writer{object});
  return line_of(object);
}

Result<ChartLine> parse_chart_line(std::string_view line) {
  // A line of ours is short and not nested; a hostile one must not make the parser recurse.
  constexpr size_t kMaxBytes = 1 << 14;
  if (line.size() > kMaxBytes) return not_a_line("");
  const ordered_json object = ordered_json::parse(line, nullptr, /*allow_exceptions=*/false);
  std::string kind, wrong;
  if (!object.is_object()) return not_a_line("");
  const Reader read{object, wrong};
  read("line", kind);
  ChartLine out;
  if (kind == "header") {
    ChartHeader header;
    header_fields(header, read);
    const auto flags = object.find("flags");
    if (flags == object.end() || !flags->is_object()) return not_a_line("/flags");
    for (const auto& [name, value] : flags->items()) {
      if (!value.is_string()) return not_a_line("/flags/" + name);
      header.flags.emplace_back(name, value.get<std::string>());
    }
    out = std::move(header);
  } else if (kind == "reference") {
    ChartReference reference;
    reference_fields(reference, read);
    out = std::move(reference);
  } else if (kind == "picture") {
    ChartRow row;
    row_fields(row, read);
    out = std::move(row);
  } else {
    return not_a_line("/line");
  }
  if (!wrong.empty()) return not_a_line(wrong);
  return out;
}

std::string chart_summary_json(const ChartSummary& s) {
  ordered_json scenes = ordered_json::array();
  for (const SceneSummary& scene : s.scenes) {
    ordered_json reference, methods = ordered_json::array();
    reference_fields(scene.reference, Writer{reference});
    for (const MethodSummary& m : scene.methods) methods.push_back(method_json(m));
    scenes.push_back({{"scene", scene.reference.scene},
                      {"reference", std::move(reference)},
                      {"methods", std::move(methods)}});
  }
  const ordered_json summary = {{"command", s.command}, {"commit", s.commit},
                                {"machine", s.machine}, {"date", s.date},
                                {"threads", s.threads}, {"width", s.width},
                                {"height", s.height},   {"seconds", s.seconds},
                                {"seeds", s.seeds},     {"scenes", std::move(scenes)}};
  return summary.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace qray
