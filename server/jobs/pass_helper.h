// What a process does while it runs no job: it samples units of another process's job, whose passes
// are shared. It decides nothing, and what it brings too late is refused. One thread calls run();
// the others may be called from any.
#pragma once

#include <atomic>
#include <mutex>

#include "core/base/clock.h"
#include "core/base/task_pool.h"
#include "server/policy/memory_budget.h"
#include "server/store/job_store.h"
#include "server/store/scene_store.h"
#include "server/store/shared_passes.h"
#include "server/store/table_store.h"

namespace qray::server {

class PassHelper {
 public:
  struct Uses {
    SharedPasses& passes;
    JobStore& jobs;
    SceneStore& scenes;
    TableStore& tables;
    TaskPool& pool;
    MemoryBudget& memory;
    const Clock& clock;
    std::function<bool()> is_free;  // it runs no job, and is to help
  };
  explicit PassHelper(const Uses& uses) : uses_(uses) {}

  // Until it is stopped.
  void run(const std::stop_token& stop);
  std::optional<JobId> helps() const;
  uint64_t samples() const { return samples_.load(std::memory_order_relaxed); }  // in all

 private:
  Status help(const SharedPasses::Open& job, const std::stop_token& stop);
  Status sample_passes(const SharedPasses::Open& job, const PreparedScene& scene,
                       const RenderSettings& settings, const std::stop_token& stop);

  const Uses uses_;
  std::atomic<uint64_t> samples_{0};
  mutable std::mutex mutex_;
  std::optional<JobId> helps_;
};

}  // namespace qray::server
