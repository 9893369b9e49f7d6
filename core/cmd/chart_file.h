// results.jsonl of a chart: its header, then each scene's reference and the pictures of its
// complete runs. A run is written whole, when it is done; what a crash left half-written is dropped
// when the file is opened again. One thread, one process.
#pragma once

#include <filesystem>
#include <span>

#include "core/base/result.h"
#include "core/laboratory/chart/chart_run.h"

namespace qray::cmd {

class ChartFile {
 public:
  // Makes the file, or goes on with what is measured there: its flags must be `header`'s (else
  // kConflict, naming those that are not). `fresh`: what is there is lost.
  static Result<ChartFile> open(const std::filesystem::path& path, const ChartHeader& header,
                                bool fresh);

  const ChartHeader& header() const { return header_; }  // of who began
  const std::vector<ChartRow>& rows() const { return rows_; }
  const ChartReference* reference(const std::string& scene) const;
  bool has_run(const ChartRun& run) const;

  Status add(const ChartReference& reference);
  Status add(std::span<const ChartRow> run);

 private:
  Status load();
  Status append(const std::string& text) const;
  std::string text() const;

  std::filesystem::path path_;
  ChartHeader header_;
  std::vector<ChartReference> references_;
  std::vector<ChartRow> rows_;
};

}  // namespace qray::cmd
