#include "server/worker.h"

#include <spdlog/spdlog.h>

#include "server/data_folder.h"

namespace qray::server {

struct Worker::Parts {
  Parts(const Config& config, std::unique_ptr<DataFolder> opened)
      : data(std::move(opened)),
        runner(data->stores(), runner_limits(config, "worker"), clock, now_ms) {}
  std::unique_ptr<DataFolder> data;
  SteadyClock clock;
  JobRunner runner;
};

Worker::Worker(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

Worker::~Worker() { stop(); }

Result<std::unique_ptr<Worker>> Worker::start(const Config& config) {
  if (config.store.empty())
    return Error{ErrorCode::kInvalid,
                 "expected postgresql://...: a worker takes its jobs from a store that a front "
                 "shares with it",
                 "--store"};
  if (config.jobs_at_once < 1)
    return Error{ErrorCode::kInvalid, "expected at least 1 for a worker", "--jobs-at-once"};
  Result<std::unique_ptr<DataFolder>> data = DataFolder::open(config, /*answers=*/false);
  if (!data.ok()) return data.error();
  if (Result<std::vector<JobRecord>> jobs = data.value()->recover(); !jobs.ok())
    return jobs.error();
  std::unique_ptr<Worker> worker(
      new Worker(std::make_unique<Parts>(config, std::move(data).value())));
  worker->parts_->runner.start({});
  return worker;
}

bool Worker::is_drained() const { return parts_->runner.is_drained(); }

void Worker::stop() { parts_->runner.stop(); }

}  // namespace qray::server
