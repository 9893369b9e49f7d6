// The measuring of a chart: its scenes, references and runs, with their pictures in its folder. One
// thread; its pool renders.
#pragma once

#include <memory>
#include <stop_token>

#include "core/base/task_pool.h"
#include "core/cmd/chart_file.h"
#include "core/cmd/chart_options.h"
#include "core/cmd/progress_line.h"
#include "core/laboratory/chart/reference.h"

namespace qray::cmd {

class ChartSession {
 public:
  ChartSession(const ChartOptions& options, const ChartPlan& plan, ChartFile file,
               std::stop_token stop);

  // Also checks that results so far are of these scenes, and that each method can run on them.
  Status load_scenes();
  size_t all_runs() const { return runs_.size(); }
  size_t complete_runs() const;
  Status measure();                // what is not complete
  ChartSummary summarize() const;  // when all is complete

 private:
  struct NamedScene {
    std::string name;
    std::shared_ptr<const PreparedScene> prepared;
  };
  Status check(const NamedScene& scene) const;
  Status measure(const NamedScene& scene, std::span<const ChartRun> runs);
  Status write_picture(const std::filesystem::path& name, const Image& picture) const;
  Result<Image> reference(const NamedScene& scene);
  Result<Reference> own_reference(const NamedScene& scene);
  Result<Reference> given_reference(const NamedScene& scene) const;

  const ChartOptions options_;
  const ChartPlan plan_;
  const std::vector<ChartRun> runs_;
  const std::filesystem::path dir_;
  ChartFile file_;
  std::stop_token stop_;
  TaskPool pool_;
  ProgressLine line_;
  std::vector<NamedScene> scenes_;
};

}  // namespace qray::cmd
