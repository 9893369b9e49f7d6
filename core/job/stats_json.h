// RenderStats as JSON: stats.json of `qray render --json`, and `stats` of the server's jobs.
// docs/stats.md lists the fields. Pure functions; any thread.
#pragma once

#include <string>

#include "core/render/stats.h"

namespace qray {

// Indented by two spaces and ended by a newline, or on one line without.
std::string stats_json(const RenderStats& stats, bool indent = true);

}  // namespace qray
