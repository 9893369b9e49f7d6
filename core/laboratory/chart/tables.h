// A chart's conclusions as text. Any thread.
#pragma once

#include <string>

#include "core/laboratory/chart/results.h"

namespace qray {

std::string chart_markdown(const ChartSummary& summary);  // table.md: a table a scene
std::string chart_text(const ChartSummary& summary);      // for a terminal: one table

}  // namespace qray
