// Keeps the moments of a job as it renders: one for each pass; its picture when the samples have
// grown enough since the last one kept, its table when they have doubled. The thread that renders.
#pragma once

#include "core/film/film.h"
#include "core/job/run_job.h"
#include "server/store/moment_store.h"

namespace qray::server {

class JobMoments {
 public:
  // `table_of`: the guide's table so far. All outlive this.
  JobMoments(MomentStore& store, JobId id, const Film& film,
             std::function<TableFile(const GuideTable&)> table_of);

  void add(const RenderProgress& progress, const RenderStats& stats, const Guide* guide);
  // Why the last attempt to write failed; empty when it did not.
  const std::string& failure() const { return failure_; }

 private:
  MomentStore& store_;
  const JobId id_;
  const Film& film_;
  std::function<TableFile(const GuideTable&)> table_of_;
  uint64_t picture_at_ = 0, table_at_ = 0;  // samples a pixel, of the last ones kept
  std::string failure_;
};

}  // namespace qray::server
