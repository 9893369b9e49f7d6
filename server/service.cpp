#include "server/service.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cstring>
#include <thread>

#include "server/handlers_assets.h"
#include "server/handlers_events.h"
#include "server/handlers_health.h"
#include "server/handlers_jobs.h"
#include "server/handlers_pictures.h"
#include "server/handlers_scenes.h"
#include "server/handlers_tables.h"
#include "server/handlers_views.h"
#include "server/handlers_web.h"
#include "server/handlers_weights.h"
#include "server/jobs/janitor.h"

namespace qray::server {
namespace fs = std::filesystem;
namespace {

int64_t now_ms() {
  return std::chrono::duration_cast<std::chrono::milliseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

// The data folder is ours while this lives; the system frees it when the process ends in any way.
class FolderLock {
 public:
  static Result<FolderLock> take(const fs::path& folder) {
    std::error_code ec;
    fs::create_directories(folder, ec);
    if (ec) return Error{ErrorCode::kIo, ec.message(), folder.string()};
    const fs::path file = folder / "lock";
    const int fd = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (fd < 0) return Error{ErrorCode::kIo, std::strerror(errno), file.string()};
    FolderLock lock(fd);
    if (::flock(fd, LOCK_EX | LOCK_NB) != 0) {
      return Error{ErrorCode::kConflict, "another server uses this data folder", folder.string()};
    }
    return lock;
  }
  FolderLock(FolderLock&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  FolderLock& operator=(FolderLock&&) = delete;
  ~FolderLock() {
    if (fd_ >= 0) ::close(fd_);
  }

 private:
  explicit FolderLock(int fd) : fd_(fd) {}
  int fd_;
};

int render_threads(int wanted) {
  return wanted > 0 ? wanted : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

}  // namespace

// In the order of their needs: what comes later uses what comes before.
struct Service::Parts {
  Parts(const Config& config, FolderLock taken, std::unique_ptr<Database> database)
      : lock(std::move(taken)),
        db(std::move(database)),
        jobs(*db, events, now_ms),
        results(config.data),
        checkpoints(config.data, config.checkpoint_mib << 20),
        upload_quota(config.assets_gib << 30),
        scenes(config.scenes, render_threads(config.threads), config.scene_mib << 20),
        web(config.web),
        event_handlers(events, jobs) {}

  FolderLock lock;
  std::unique_ptr<Database> db;
  EventLog events;
  JobStore jobs;
  std::unique_ptr<TableStore> tables;
  std::unique_ptr<WeightsStore> weights;
  ResultStore results;
  CheckpointStore checkpoints;
  DiskQuota upload_quota;
  std::unique_ptr<AssetStore> assets;
  std::unique_ptr<UploadedScenes> uploads;
  SceneStore scenes;
  SteadyClock clock;
  std::unique_ptr<JobRunner> runner;
  std::unique_ptr<Janitor> janitor;
  std::unique_ptr<JobHandlers> job_handlers;
  std::unique_ptr<PictureHandlers> picture_handlers;
  std::unique_ptr<ViewHandlers> view_handlers;
  std::unique_ptr<TableHandlers> table_handlers;
  std::unique_ptr<WeightsHandlers> weights_handlers;
  std::unique_ptr<SceneImporter> importer;
  std::unique_ptr<SceneHandlers> scene_handlers;
  std::unique_ptr<AssetHandlers> asset_handlers;
  WebHandlers web;
  EventHandlers event_handlers;
  std::unique_ptr<HttpServer> http;
  int port = 0;
};

Service::Service(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

Service::~Service() { stop(); }

Result<std::unique_ptr<Service>> Service::start(const Config& config, const HttpLimits& http) {
  Result<FolderLock> lock = FolderLock::take(config.data);
  if (!lock.ok()) return lock.error();
  Result<std::unique_ptr<Database>> db = Database::open(config.data / "qray.sqlite");
  if (!db.ok()) return db.error();
  auto parts = std::make_unique<Parts>(config, std::move(lock).value(), std::move(db).value());

  // Step 1: what the last run left.
  Result<std::unique_ptr<TableStore>> tables =
      TableStore::open(*parts->db, config.data, config.table_mib << 20);
  if (!tables.ok()) return tables.error();
  parts->tables = std::move(tables).value();
  Result<std::unique_ptr<WeightsStore>> weights = WeightsStore::open(config.data);
  if (!weights.ok()) return weights.error();
  parts->weights = std::move(weights).value();
  Result<std::unique_ptr<AssetStore>> assets = AssetStore::open(config.data, parts->upload_quota);
  if (!assets.ok()) return assets.error();
  parts->assets = std::move(assets).value();
  Result<std::unique_ptr<UploadedScenes>> uploads =
      UploadedScenes::open(config.data, parts->upload_quota);
  if (!uploads.ok()) return uploads.error();
  parts->uploads = std::move(uploads).value();
  parts->scenes.add_uploads(*parts->uploads);
  Result<std::vector<JobRecord>> queued = parts->jobs.recover();
  if (!queued.ok()) return queued.error();
  parts->checkpoints.tidy([&](JobId id) {
    using enum CheckpointStore::Keep;
    const Result<JobRecord> job = parts->jobs.get(id);
    if (!job.ok()) return kNo;
    if (!has_ended(job.value().state)) return kOpen;
    return job.value().state == JobState::kSucceeded ? kFinished : kNo;
  });

  // Step 2: the routes, and the port: when it is taken, no job may start.
  const Stores stores{parts->jobs,    *parts->tables, *parts->weights,
                      parts->results, parts->scenes,  parts->checkpoints};
  const JobRunner::Limits runner_limits{render_threads(config.threads), config.jobs_at_once,
                                        config.max_queued};
  parts->runner = std::make_unique<JobRunner>(stores, runner_limits, parts->clock, now_ms);
  parts->job_handlers = std::make_unique<JobHandlers>(*parts->runner, stores, parts->events);
  parts->picture_handlers = std::make_unique<PictureHandlers>(*parts->runner, stores);
  parts->view_handlers = std::make_unique<ViewHandlers>(stores);
  parts->table_handlers = std::make_unique<TableHandlers>(*parts->tables, now_ms);
  parts->weights_handlers = std::make_unique<WeightsHandlers>(*parts->weights);
  const ImportLimits import_limits{config.program, config.import_mib, config.import_seconds,
                                   config.unpacked_mib << 20};
  parts->importer = std::make_unique<SceneImporter>(
      *parts->assets, *parts->uploads, parts->upload_quota, import_limits, config.imports);
  parts->scene_handlers = std::make_unique<SceneHandlers>(SceneHandlers::Uses{
      *parts->importer, parts->scenes, *parts->uploads, *parts->assets, parts->jobs});
  parts->asset_handlers = std::make_unique<AssetHandlers>(*parts->assets, config.asset_mib << 20);
  Router router;
  parts->job_handlers->add_to(router);
  parts->picture_handlers->add_to(router);
  parts->view_handlers->add_to(router);
  parts->event_handlers.add_to(router);
  parts->web.add_to(router);
  parts->table_handlers->add_to(router);
  parts->weights_handlers->add_to(router);
  parts->asset_handlers->add_to(router);
  parts->scene_handlers->add_to(router);
  add_health_routes(router);
  parts->http = std::make_unique<HttpServer>(std::move(router), http);
  Result<int> port = parts->http->start(config.host, config.port);
  if (!port.ok()) return port.error();
  parts->port = port.value();

  // Step 3: work.
  parts->runner->start(queued.value());
  parts->janitor = std::make_unique<Janitor>(*parts->runner, parts->jobs, config.keep_days, now_ms);
  return std::unique_ptr<Service>(new Service(std::move(parts)));
}

void Service::stop() {
  if (!parts_->http) return;
  parts_->events.close();
  parts_->view_handlers->stop();
  parts_->importer->stop();
  parts_->http->stop();
  parts_->janitor.reset();
  parts_->runner->stop();
  parts_->http.reset();
}

int Service::port() const { return parts_->port; }

size_t Service::stream_count() const { return parts_->event_handlers.stream_count(); }

size_t Service::connection_count() const {
  return parts_->http ? parts_->http->connection_count() : 0;
}

}  // namespace qray::server
