// Everything that is kept: the records, and the files of the data folder. Of one server alone, or,
// where the records are in a database that several share, of all of them.
#pragma once

#include <memory>

#include "server/jobs/job_runner.h"
#include "server/operation/config.h"
#include "server/operation/metrics.h"
#include "server/store/asset_store.h"
#include "server/store/records.h"
#include "server/store/uploaded_scenes.h"

namespace qray::server {

int64_t now_ms();  // the time of day
int render_threads(const Config& config);
JobRunner::Limits runner_limits(const Config& config, const char* kind);

// Taken by this process while this lives; the system frees it when the process ends in any way.
class FolderLock {
 public:
  // kConflict: a server uses it, and not both share it.
  static Result<FolderLock> take(const std::filesystem::path& folder, bool shared);
  FolderLock(FolderLock&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  FolderLock& operator=(FolderLock&&) = delete;
  ~FolderLock();

 private:
  explicit FolderLock(int fd) : fd_(fd) {}
  int fd_;
};

class DataFolder {
 public:
  // Takes the folder, and tidies up what the last run left. `answers`: this process answers
  // requests, so it reads the events and keeps the whole folder tidy.
  static Result<std::unique_ptr<DataFolder>> open(const Config& config, bool answers);
  // Of jobs that wait, for this process to run.
  Result<std::vector<JobRecord>> recover();
  Stores stores();

 private:
  DataFolder(const Config& config, FolderLock taken);
  Status open_files(const Config& config, bool answers);

  FolderLock lock_;
  bool answers_ = true;
  std::chrono::seconds left_{0};  // what is younger than that, and nobody's, is left alone

 public:
  Metrics metrics;
  EventLog events;
  std::unique_ptr<Records> records;
  std::unique_ptr<TableStore> tables;
  std::unique_ptr<WeightsStore> weights;
  ResultStore results;
  CheckpointStore checkpoints;
  MomentStore moments;
  DiskQuota upload_quota;
  std::unique_ptr<AssetStore> assets;
  std::unique_ptr<UploadedScenes> uploads;
  SceneStore scenes;
};

}  // namespace qray::server
