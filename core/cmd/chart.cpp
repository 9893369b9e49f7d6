// qray chart: error against time of methods on scenes, measured, concluded and drawn.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "core/base/build_commit.h"
#include "core/cmd/chart_session.h"
#include "core/cmd/commands.h"
#include "core/cmd/files.h"
#include "core/cmd/report.h"
#include "core/cmd/stop_on_signal.h"
#include "core/laboratory/chart/chart_json.h"
#include "core/laboratory/chart/page.h"
#include "core/laboratory/chart/plot.h"
#include "core/laboratory/chart/tables.h"

namespace qray::cmd {
namespace {

Status write_results(const ChartSummary& summary, const std::filesystem::path& dir) {
  if (Status s = write_text(dir / "summary.json", chart_summary_json(summary)); !s) return s;
  if (Status s = write_text(dir / "table.md", chart_markdown(summary)); !s) return s;
  std::fputs(chart_text(summary).c_str(), stdout);
  if (Status s = write_page(summary, dir); !s) return s;
  return write_plots(summary, dir);  // last: all else is there without gnuplot
}

Status run(ChartOptions o) {
  const Result<ChartPlan> plan = complete(o);
  if (!plan) return plan.error();
  std::error_code failed;
  std::filesystem::create_directories(o.out, failed);
  if (failed) return Error{ErrorCode::kIo, failed.message(), o.out};
  const StopOnSignal stop;
  Result<ChartFile> file =
      ChartFile::open(std::filesystem::path(o.out) / "results.jsonl", chart_header(o), o.fresh);
  if (!file) return file.error();
  const std::string begun_with = file.value().header().commit;
  ChartSession chart(o, plan.value(), std::move(file).value(), stop.token());
  if (Status s = chart.load_scenes(); !s) return s;
  if (chart.complete_runs() < chart.all_runs() && begun_with != build_commit())
    return Error{ErrorCode::kConflict,
                 "was begun by commit " + begun_with + ", this is " + build_commit() +
                     ". Go on with that one, give another folder, or --fresh",
                 o.out};
  if (Status s = chart.measure(); !s) {
    if (s.error().code != ErrorCode::kCanceled) return s;
    return Error{ErrorCode::kCanceled,
                 "interrupted: " + std::to_string(chart.complete_runs()) + " of " +
                     std::to_string(chart.all_runs()) +
                     " runs are complete. The same command goes on",
                 o.out};
  }
  return write_results(chart.summarize(), o.out);
}

}  // namespace

void add_chart(CLI::App& app, int& exit_code) {
  auto o = std::make_shared<ChartOptions>();
  CLI::App* sub = app.add_subcommand(
      "chart", "error against time of methods, measured and drawn (docs/charts/README.md)");
  add_chart_options(*sub, *o);
  sub->callback([o, &exit_code] {
    if (Status s = run(*o); !s) exit_code = report(s.error());
  });
}

}  // namespace qray::cmd
