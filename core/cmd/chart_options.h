// The options of `qray chart`, and what they make. One thread.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/cmd/files.h"
#include "core/laboratory/chart/chart_run.h"

namespace CLI {
class App;
}

namespace qray::cmd {

struct ChartOptions {
  std::vector<std::string> scenes;
  std::string methods, size, ref, ref_method = "none", ref_cache, out;
  std::optional<double> seconds, ref_seconds;
  std::optional<int> seeds;
  double warm_turn = 0;
  int threads = default_threads();
  bool warm = false, quick = false, fresh = false, quiet = false;
};

void add_chart_options(CLI::App& app, ChartOptions& options);

// Fills in the defaults of what was not given.
Result<ChartPlan> complete(ChartOptions& options);

// Of completed options, on this machine, now.
ChartHeader chart_header(const ChartOptions& options);

}  // namespace qray::cmd
