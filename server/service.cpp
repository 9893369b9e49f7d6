#include "server/service.h"

#include <spdlog/spdlog.h>

#include "core/base/file.h"
#include "proto/openapi.h"
#include "server/api/handlers_assets.h"
#include "server/api/handlers_compare.h"
#include "server/api/handlers_events.h"
#include "server/api/handlers_frames.h"
#include "server/api/handlers_health.h"
#include "server/api/handlers_jobs.h"
#include "server/api/handlers_live.h"
#include "server/api/handlers_passes.h"
#include "server/api/handlers_pictures.h"
#include "server/api/handlers_scenes.h"
#include "server/api/handlers_tables.h"
#include "server/api/handlers_views.h"
#include "server/api/handlers_web.h"
#include "server/api/handlers_webhooks.h"
#include "server/api/handlers_weights.h"
#include "server/api/handlers_workers.h"
#include "server/data_folder.h"
#include "server/http/access.h"
#include "server/http/host.h"
#include "server/jobs/janitor.h"
#include "server/operation/metrics.h"
#include "server/webhooks/webhook_sender.h"

namespace qray::server {
namespace fs = std::filesystem;
namespace {

constexpr uint64_t kMaxOpenApiBytes = 1u << 20;

// For what ends after a time, whatever becomes of the clock.
int64_t steady_ms() {
  return std::chrono::duration_cast<std::chrono::milliseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

Result<std::string> read_openapi(const fs::path& file) {
  const Result<Bytes> yaml = read_file(file, kMaxOpenApiBytes);
  if (!yaml.ok()) return yaml.error();
  return proto::openapi_to_json(
      {reinterpret_cast<const char*>(yaml.value().data()), yaml.value().size()});
}

proto::RequestLimits request_limits(const Config& config) {
  proto::RequestLimits limits;
  limits.max_bytes = config.json_mib << 20;
  limits.max_nesting = config.json_depth;
  limits.max_pixels = config.max_pixels;
  limits.max_seconds = config.max_job_seconds;
  return limits;
}

HttpLimits http_limits(const Config& config) {
  const auto ms = [](double seconds) {
    return std::chrono::milliseconds(static_cast<int64_t>(seconds * 1000));
  };
  HttpLimits limits;
  limits.head.max_body_bytes = config.json_mib << 20;
  limits.stream.idle = ms(config.idle_seconds);
  limits.stream.head = ms(config.head_seconds);
  limits.stream.body = ms(config.body_seconds);
  limits.max_connections = config.max_connections;
  return limits;
}

// Targets have no spaces and no control characters: the head check refuses them.
void log_exchange(const Exchange& e) {
  const auto level = e.status >= 500   ? spdlog::level::warn
                     : e.status >= 400 ? spdlog::level::info
                                       : spdlog::level::debug;
  const auto or_dash = [](const std::string& text) { return text.empty() ? "-" : text; };
  spdlog::log(level,
              "request={} client={} user={} method={} target={} status={} ms={:.1f} in={} out={}",
              e.id, or_dash(e.client), or_dash(e.user), or_dash(e.method), or_dash(e.target),
              e.status, e.seconds * 1000, e.bytes_in, e.bytes_out);
}

// Without tokens on an address that others reach, anybody could use this server.
Result<Tokens> tokens_of(const Config& config) {
  if (!config.tokens.empty()) return Tokens::read(config.tokens);
  if (!is_loopback(config.host) && !config.no_auth) {
    return Error{ErrorCode::kInvalid,
                 "others reach this address, so tokens are needed: `qrayd token NAME admin` makes "
                 "one and its line for a file that --tokens names; or --no-auth",
                 "--host " + config.host};
  }
  return Tokens();
}

}  // namespace

// In the order of their needs: what comes later uses what comes before.
struct Service::Parts {
  Parts(const Config& config, std::unique_ptr<DataFolder> opened, Tokens tokens)
      : tokens_file(config.tokens),
        access(std::move(tokens), config.no_auth ? Access::Names() : config.names, steady_ms),
        data(std::move(opened)),
        web(config.web, config.web_lib),
        event_handlers(data->events, data->records->jobs(), config.max_streams) {}

  const std::filesystem::path tokens_file;
  Access access;
  std::unique_ptr<DataFolder> data;
  SteadyClock clock;
  std::unique_ptr<JobRunner> runner;
  std::unique_ptr<LiveSessions> live;
  std::unique_ptr<Janitor> janitor;
  std::unique_ptr<WebhookSender> sender;
  std::unique_ptr<JobHandlers> job_handlers;
  std::unique_ptr<PictureSource> pictures;
  std::counting_semaphore<> encoders{2};
  std::unique_ptr<PictureHandlers> picture_handlers;
  std::unique_ptr<CompareHandlers> compare_handlers;
  std::unique_ptr<ViewHandlers> view_handlers;
  std::unique_ptr<TableHandlers> table_handlers;
  std::unique_ptr<FrameHandlers> frame_handlers;
  std::unique_ptr<PassHandlers> pass_handlers;
  std::unique_ptr<WeightsHandlers> weights_handlers;
  std::unique_ptr<WebhookHandlers> webhook_handlers;
  std::unique_ptr<WorkerHandlers> worker_handlers;
  std::unique_ptr<SceneImporter> importer;
  std::unique_ptr<SceneThumbnails> thumbnails;
  std::unique_ptr<SceneHandlers> scene_handlers;
  std::unique_ptr<AssetHandlers> asset_handlers;
  std::unique_ptr<HealthHandlers> health_handlers;
  std::unique_ptr<LiveHandlers> live_handlers;
  WebHandlers web;
  EventHandlers event_handlers;
  std::string openapi;  // JSON
  std::vector<Router::RouteInfo> routes;
  std::unique_ptr<HttpServer> http;
  int port = 0;
};

Service::Service(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

Service::~Service() { stop(); }

Result<std::unique_ptr<Service>> Service::start(const Config& config) {
  if (config.jobs_at_once < 1 && config.store.empty())
    return Error{ErrorCode::kInvalid, "expected at least 1 where nobody else runs jobs",
                 "--jobs-at-once"};
  Result<Tokens> tokens = tokens_of(config);
  if (!tokens.ok()) return tokens.error();
  Result<std::unique_ptr<DataFolder>> opened = DataFolder::open(config, /*answers=*/true);
  if (!opened.ok()) return opened.error();
  auto parts =
      std::make_unique<Parts>(config, std::move(opened).value(), std::move(tokens).value());
  DataFolder& data = *parts->data;

  Result<std::string> openapi = read_openapi(config.openapi);
  if (!openapi.ok()) return openapi.error();
  parts->openapi = std::move(openapi).value();

  // Step 1: what the last run left.
  Result<std::vector<JobRecord>> queued = data.recover();
  if (!queued.ok()) return queued.error();

  // Step 2: the routes, and the port: when it is taken, no job may start.
  const Stores stores = data.stores();
  const proto::RequestLimits requests = request_limits(config);
  parts->runner =
      std::make_unique<JobRunner>(stores, runner_limits(config, "front"), parts->clock, now_ms);
  parts->job_handlers =
      std::make_unique<JobHandlers>(*parts->runner, stores, data.events, requests);
  parts->pictures = std::make_unique<PictureSource>(*parts->runner, stores);
  parts->picture_handlers =
      std::make_unique<PictureHandlers>(*parts->runner, *parts->pictures, stores, parts->encoders);
  parts->frame_handlers = std::make_unique<FrameHandlers>(*parts->runner, *parts->pictures, stores,
                                                          config.data, parts->encoders);
  parts->pass_handlers = std::make_unique<PassHandlers>(stores, parts->encoders);
  parts->compare_handlers =
      std::make_unique<CompareHandlers>(*parts->pictures, stores, parts->encoders);
  parts->view_handlers = std::make_unique<ViewHandlers>(*parts->pictures, stores);
  parts->table_handlers = std::make_unique<TableHandlers>(*data.tables, requests, now_ms);
  parts->weights_handlers = std::make_unique<WeightsHandlers>(*data.weights);
  parts->worker_handlers = std::make_unique<WorkerHandlers>(stores.shared);
  parts->webhook_handlers = std::make_unique<WebhookHandlers>(data.records->webhooks(), requests);
  const ImportLimits import_limits{config.program, config.import_mib, config.import_seconds,
                                   config.unpacked_mib << 20, config.max_triangles};
  Result<std::unique_ptr<SceneThumbnails>> thumbnails =
      SceneThumbnails::open(config.data, data.scenes);
  if (!thumbnails.ok()) return thumbnails.error();
  parts->thumbnails = std::move(thumbnails).value();
  parts->importer = std::make_unique<SceneImporter>(*data.assets, *data.uploads, data.upload_quota,
                                                    import_limits, config.imports);
  parts->scene_handlers = std::make_unique<SceneHandlers>(
      SceneHandlers::Uses{*parts->importer, data.scenes, *data.uploads, *data.assets,
                          data.records->jobs(), *parts->thumbnails, requests});
  parts->asset_handlers = std::make_unique<AssetHandlers>(*data.assets, config.asset_mib << 20);
  parts->health_handlers = std::make_unique<HealthHandlers>(
      HealthHandlers::Uses{data.records->jobs(), data.metrics, parts->event_handlers,
                           [&http = parts->http] { return http ? http->connection_count() : 0; },
                           [&live = parts->live] { return live->count(); }, now_ms, config.data,
                           uint64_t{config.min_free_mib} << 20, parts->openapi, stores.shared});
  parts->live = std::make_unique<LiveSessions>(
      stores, parts->runner->pool(), parts->runner->memory(),
      LiveSessions::Limits{config.live_sessions, config.live_idle_seconds}, parts->clock, now_ms);
  parts->live_handlers = std::make_unique<LiveHandlers>(*parts->live, stores, requests);
  Router router;
  parts->access.add_to(router);
  parts->job_handlers->add_to(router);
  parts->picture_handlers->add_to(router);
  parts->frame_handlers->add_to(router);
  parts->pass_handlers->add_to(router);
  parts->compare_handlers->add_to(router);
  parts->view_handlers->add_to(router);
  parts->event_handlers.add_to(router);
  parts->web.add_to(router);
  parts->table_handlers->add_to(router);
  parts->weights_handlers->add_to(router);
  parts->webhook_handlers->add_to(router);
  parts->worker_handlers->add_to(router);
  parts->asset_handlers->add_to(router);
  parts->scene_handlers->add_to(router);
  parts->health_handlers->add_to(router);
  parts->live_handlers->add_to(router);
  parts->routes = router.routes();
  router.set_parameters(proto::query_parameters(parts->openapi));
  parts->http = std::make_unique<HttpServer>(
      std::move(router), http_limits(config),
      HttpHooks{[p = parts.get()](auto& req, Scope needed) { return p->access.judge(req, needed); },
                [p = parts.get()](auto& req) { return p->access.user(req); },
                [p = parts.get()](const Exchange& exchange) {
                  p->data->metrics.add_exchange(exchange);
                  log_exchange(exchange);
                }});
  Result<int> port = parts->http->start(config.host, config.port);
  if (!port.ok()) return port.error();
  parts->port = port.value();

  // Step 3: work.
  parts->runner->start(queued.value());
  parts->janitor =
      std::make_unique<Janitor>(*parts->runner, data.records->jobs(), config.keep_days, now_ms);
  parts->sender =
      std::make_unique<WebhookSender>(data.records->webhooks(), data.records->jobs(),
                                      WebhookSender::Limits{config.private_webhooks}, now_ms);
  return std::unique_ptr<Service>(new Service(std::move(parts)));
}

void Service::stop() {
  if (!parts_->http) return;
  parts_->health_handlers->drain();
  parts_->data->events.close();
  parts_->view_handlers->stop();
  parts_->importer->stop();
  parts_->thumbnails->stop();
  parts_->live->stop();
  parts_->http->stop();
  parts_->sender->stop();
  parts_->janitor.reset();
  parts_->runner->stop();
  parts_->http.reset();
}

void Service::reload_tokens() {
  Result<Tokens> tokens = Tokens::read(parts_->tokens_file);
  if (!tokens.ok()) return spdlog::error("the tokens stay as they were: {}", tokens.error().text());
  parts_->access.replace(std::move(tokens).value());
  spdlog::info("tokens read again from {}", parts_->tokens_file.string());
}

int Service::port() const { return parts_->port; }

const std::vector<Router::RouteInfo>& Service::routes() const { return parts_->routes; }

size_t Service::stream_count() const { return parts_->event_handlers.stream_count(); }

size_t Service::connection_count() const {
  return parts_->http ? parts_->http->connection_count() : 0;
}

}  // namespace qray::server
