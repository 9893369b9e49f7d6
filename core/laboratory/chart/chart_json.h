// What a chart measured and concludes as JSON: the lines of results.jsonl, and summary.json.
// docs/charts/README.md lists the fields. Numbers that are infinite are null. Pure functions; any
// thread.
#pragma once

#include <string>
#include <string_view>
#include <variant>

#include "core/base/result.h"
#include "core/laboratory/chart/results.h"

namespace qray {

// On one line, without its end.
std::string chart_line(const ChartHeader& header);
std::string chart_line(const ChartReference& reference);
std::string chart_line(const ChartRow& row);

using ChartLine = std::variant<ChartHeader, ChartReference, ChartRow>;
// Errors name the field as a pointer.
Result<ChartLine> parse_chart_line(std::string_view line);

// Indented, ended by a newline.
std::string chart_summary_json(const ChartSummary& summary);

}  // namespace qray
