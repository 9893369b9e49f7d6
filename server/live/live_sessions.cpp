#include "server/live/live_sessions.h"

#include <spdlog/spdlog.h>

#include "core/recover/included_networks.h"
#include "server/jobs/job_settings.h"
#include "server/operation/metrics.h"

namespace qray::server {
namespace {

constexpr size_t kMaxTablesTried = 8;
constexpr size_t kPixelBytes = 600;  // of views, histories, film, recovery and pictures, about

size_t memory_needed(const RenderSettings& settings) {
  return static_cast<size_t>(settings.width) * static_cast<size_t>(settings.height) * kPixelBytes +
         (settings.method == "none" ? 0 : settings.max_table_bytes);
}

}  // namespace

void LiveSessions::forget_ended() {
  std::erase_if(sessions_, [](const auto& entry) { return entry.second->ended(); });
}

Result<std::shared_ptr<LiveSession>> LiveSessions::open(const proto::LiveRequest& request) {
  std::string id;
  {
    std::lock_guard lock(mutex_);
    forget_ended();
    if (stopped_ || sessions_.size() + opening_ >= limits_.at_once)
      return Error{ErrorCode::kBusy,
                   "expected at most " + std::to_string(limits_.at_once) +
                       " live sessions at once: end one, or come again",
                   ""};
    ++opening_;
    id = std::to_string(++opened_);
  }
  id = "l" + std::string(id.size() < 6 ? 6 - id.size() : 0, '0') + id;
  Result<LiveSession::Start> start = prepare(request);
  std::shared_ptr<LiveSession> session;
  if (start.ok()) {
    start.value().id = id;
    session = std::make_shared<LiveSession>(std::move(start).value(), threads_, clock_);
  }
  std::lock_guard lock(mutex_);
  --opening_;
  if (!start.ok()) return start.error();
  if (stopped_) return Error{ErrorCode::kBusy, "the server stops", ""};
  sessions_[id] = session;
  return session;
}

Result<LiveSession::Start> LiveSessions::prepare(const proto::LiveRequest& request) {
  Result<std::shared_ptr<const PreparedScene>> scene = stores_.scenes.prepare(request.scene);
  if (!scene.ok()) return stores_.scenes.without_folder(scene.error());
  LiveSession::Start start;
  start.request = request;
  start.scene = std::move(scene).value();
  start.idle_seconds = limits_.idle_seconds;
  RenderSettings& s = start.settings.render;
  const Scene& data = start.scene->scene;
  s.method = request.method;
  s.width = request.width.value_or(data.width + data.width % 2);
  s.height = request.height.value_or(data.height + data.height % 2);
  s.max_depth = request.max_depth.value_or(data.max_depth);
  s.pixels = pixels_named(request.pixels).value_or(Pixels::kAdaptive);
  s.seed = request.seed;
  s.max_table_bytes = stores_.tables.max_bytes();
  s.camera = camera_of(request.camera.value_or(proto::CameraRequest{}), data.camera);
  if (Status status = check_settings(s, kMaxPixels); !status.ok()) return status.error();
  std::optional<MemoryBudget::Part> memory = memory_.take_now(memory_needed(s));
  if (!memory)
    return Error{ErrorCode::kBusy, "there is no memory beside the jobs that run: come again", ""};
  start.memory = std::move(*memory);
  start.settings.frame_seconds = request.frame_ms / 1000;
  Result<std::unique_ptr<Guide>> made = guide(*start.scene, s, request.table, start.table);
  if (!made.ok()) return made.error();
  start.guide = std::move(made).value();
  if (Status status = network(*start.scene, request.recover, start); !status.ok())
    return status.error();
  if (stores_.metrics)
    start.made = [metrics = stores_.metrics](const LiveFrame& frame) { metrics->add_frame(frame); };
  if (request.table != "none")
    start.leave = [this, request](const TableFile& table, const GuideStats& stats) {
      keep(request, table, stats);
    };
  return start;
}

// From the newest table that can be used, as jobs do.
Result<std::unique_ptr<Guide>> LiveSessions::guide(const PreparedScene& scene,
                                                   const RenderSettings& settings,
                                                   const std::string& wanted,
                                                   std::optional<TableHeader>& parent) {
  std::vector<std::string> ids;
  if (wanted == "auto" && settings.method != "none") {
    Result<std::vector<std::string>> fitting =
        stores_.tables.fitting(table_method(settings.method), scene.hash, kMaxTablesTried);
    if (!fitting.ok()) return fitting.error();
    ids = std::move(fitting).value();
  } else if (wanted != "none" && wanted != "auto") {
    ids = {wanted};
  }
  for (const std::string& id : ids) {
    Result<TableFile> table = stores_.tables.load(id);
    std::optional<Error> why;
    if (table.ok()) {
      std::optional<TableFile> file = std::move(table).value();
      Result<std::unique_ptr<Guide>> made = load_guide(scene, settings, file);
      if (made.ok()) {
        parent = std::move(file->header);
        return made;
      }
      why = made.error();
    } else {
      why = table.error();
    }
    if (wanted != "auto") return Error{ErrorCode::kInvalid, why->message, "/table"};
    spdlog::warn("table {} was not used for a live session: {}", id, why->message);
  }
  return make_guide(settings.method, scene.guide_setup(settings));
}

Status LiveSessions::network(const PreparedScene& scene, std::string wanted,
                             LiveSession::Start& start) {
  if (wanted == "auto") wanted = stores_.weights.fitting(scene.hash).value_or("default");
  start.recover = wanted;
  if (Result<Network> included = included_network(wanted); included.ok()) {
    start.network = std::move(included).value();
    return {};
  }
  Result<WeightsFile> weights = stores_.weights.load(wanted);
  if (!weights.ok()) return Error{ErrorCode::kInvalid, weights.error().message, "/recover"};
  start.network = std::move(weights.value().network);
  return {};
}

void LiveSessions::keep(const proto::LiveRequest& request, const TableFile& table,
                        const GuideStats& stats) {
  const TableHeader& header = table.header;
  const Status kept =
      stores_.tables.add(table, {header.id, request.scene, header.method, header.parents, now_ms_(),
                                 0, stats.states, header.samples_seen, ""});
  if (!kept.ok()) spdlog::error("a live session's table is lost: {}", kept.error().text());
}

std::shared_ptr<LiveSession> LiveSessions::find(const std::string& id) {
  std::lock_guard lock(mutex_);
  forget_ended();
  const auto found = sessions_.find(id);
  return found == sessions_.end() ? nullptr : found->second;
}

size_t LiveSessions::count() {
  std::lock_guard lock(mutex_);
  forget_ended();
  return sessions_.size();
}

void LiveSessions::stop() {
  std::map<std::string, std::shared_ptr<LiveSession>> sessions;
  {
    std::lock_guard lock(mutex_);
    stopped_ = true;
    sessions.swap(sessions_);
  }
  for (const auto& [id, session] : sessions) session->end();
  for (const auto& [id, session] : sessions)
    while (!session->ended()) (void)session->wait(UINT64_MAX, std::chrono::milliseconds(100));
}

}  // namespace qray::server
