#include "server/data_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cstring>
#include <thread>

#include "server/open_records.h"
#include "server/store/leftovers.h"

namespace qray::server {
namespace {

// What is younger may be another server's, which is writing it.
constexpr std::chrono::hours kLeftWhereShared{1};

SceneLimits scene_limits(const Config& config) {
  SceneLimits limits;
  limits.max_triangles = config.max_triangles;
  return limits;
}

}  // namespace

int64_t now_ms() {
  return std::chrono::duration_cast<std::chrono::milliseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

int render_threads(const Config& config) {
  if (config.threads > 0) return config.threads;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

JobRunner::Limits runner_limits(const Config& config, const char* kind) {
  return {render_threads(config),
          config.jobs_at_once,
          config.max_queued,
          config.jobs_mib << 20,
          kind,
          config.shared_pass_seconds};
}

Result<FolderLock> FolderLock::take(const std::filesystem::path& folder, bool shared) {
  std::error_code ec;
  std::filesystem::create_directories(folder, ec);
  if (ec) return Error{ErrorCode::kIo, ec.message(), folder.string()};
  const std::filesystem::path file = folder / "lock";
  const int fd = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (fd < 0) return Error{ErrorCode::kIo, std::strerror(errno), file.string()};
  FolderLock lock(fd);
  if (::flock(fd, (shared ? LOCK_SH : LOCK_EX) | LOCK_NB) != 0) {
    return Error{ErrorCode::kConflict, "another server uses this data folder", folder.string()};
  }
  return lock;
}

FolderLock::~FolderLock() {
  if (fd_ >= 0) ::close(fd_);
}

DataFolder::DataFolder(const Config& config, FolderLock taken)
    : lock_(std::move(taken)),
      results(config.data),
      checkpoints(config.data, config.checkpoint_mib << 20, this_build()),
      moments(config.data, config.moments_mib << 20),
      upload_quota(config.assets_gib << 30),
      scenes(config.scenes, render_threads(config), config.scene_mib << 20, scene_limits(config)) {}

Result<std::unique_ptr<DataFolder>> DataFolder::open(const Config& config, bool answers) {
  Result<FolderLock> lock = FolderLock::take(config.data, !config.store.empty());
  if (!lock.ok()) return lock.error();
  std::unique_ptr<DataFolder> data(new DataFolder(config, std::move(lock).value()));
  Result<std::unique_ptr<Records>> records =
      open_records(config, data->events, now_ms, /*publishes=*/answers);
  if (!records.ok()) return records.error();
  data->records = std::move(records).value();
  if (Status s = data->open_files(config, answers); !s.ok()) return s.error();
  return data;
}

Status DataFolder::open_files(const Config& config, bool answers) {
  Result<std::unique_ptr<TableStore>> opened =
      TableStore::open(records->tables(), config.data, config.table_mib << 20);
  if (!opened.ok()) return opened.error();
  tables = std::move(opened).value();
  Result<std::unique_ptr<WeightsStore>> networks = WeightsStore::open(config.data);
  if (!networks.ok()) return networks.error();
  weights = std::move(networks).value();
  answers_ = answers;
  if (records->shared()) left_ = kLeftWhereShared;
  Result<std::unique_ptr<AssetStore>> files = AssetStore::open(config.data, upload_quota, left_);
  if (!files.ok()) return files.error();
  assets = std::move(files).value();
  Result<std::unique_ptr<UploadedScenes>> uploaded =
      UploadedScenes::open(config.data, upload_quota, left_);
  if (!uploaded.ok()) return uploaded.error();
  uploads = std::move(uploaded).value();
  scenes.add_uploads(*uploads);
  return answers ? tidy_data_folder(config.data, records->jobs(), *tables, left_) : Status();
}

Result<std::vector<JobRecord>> DataFolder::recover() {
  JobStore& jobs = records->jobs();
  Result<std::vector<JobRecord>> queued = jobs.recover();
  if (!queued.ok()) return queued.error();
  if (answers_)
    for (JobId id : moments.remove_others())
      if (jobs.get(id).ok())
        jobs.log(id, "info",
                 "the moments kept so far are left out: another version of qray wrote them");
  checkpoints.tidy(
      [&](JobId id) {
        using enum CheckpointStore::Keep;
        const Result<JobRecord> job = jobs.get(id);
        if (!job.ok()) return job.error().code == ErrorCode::kNotFound ? kNo : kOpen;
        if (!has_ended(job.value().state)) return kOpen;
        return job.value().state == JobState::kSucceeded ? kFinished : kNo;
      },
      left_);
  return queued;
}

Stores DataFolder::stores() {
  return {records->jobs(), *tables, *weights, results,           scenes,
          checkpoints,     moments, &metrics, records->shared(), records->passes()};
}

}  // namespace qray::server
