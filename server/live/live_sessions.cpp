#include "server/live/live_sessions.h"

#include <spdlog/spdlog.h>

#include "core/settings/job_settings.h"
#include "server/operation/metrics.h"
#include "server/policy/memory_needed.h"
#include "server/policy/network_choice.h"
#include "server/policy/table_choice.h"

namespace qray::server {
namespace {

RenderSettings settings_of(const proto::LiveRequest& request, const Scene& scene) {
  RenderSettings s;
  s.method = request.method;
  s.width = request.width.value_or(scene.width + scene.width % 2);
  s.height = request.height.value_or(scene.height + scene.height % 2);
  s.max_depth = request.max_depth.value_or(scene.max_depth);
  s.pixels = pixels_named(request.pixels).value_or(Pixels::kByNoise);
  s.seed = request.seed;
  s.camera = camera_of(request.camera.value_or(CameraRequest{}), scene.camera);
  return s;
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
  s = settings_of(request, start.scene->scene);
  s.max_table_bytes = stores_.tables.max_bytes();
  if (Status status = check_settings(s, kMaxPixels); !status.ok()) return status.error();
  std::optional<MemoryBudget::Part> memory = memory_.take_now(live_memory(s));
  if (!memory)
    return Error{ErrorCode::kBusy, "there is no memory beside the jobs that run: come again", ""};
  start.memory = std::move(*memory);
  start.settings.frame_seconds = request.frame_ms / 1000;
  if (Status status = choose_table(request.table, start); !status.ok()) return status.error();
  start.recover = network_name(stores_.weights, start.scene->hash, request.recover);
  Result<Network> network = load_network(stores_.weights, start.recover);
  if (!network.ok()) return Error{ErrorCode::kInvalid, network.error().message, "/recover"};
  start.network = std::move(network).value();
  if (stores_.metrics)
    start.made = [metrics = stores_.metrics](const LiveFrame& frame) { metrics->add_frame(frame); };
  if (request.table != "none")
    start.leave = [this, request](const TableFile& table, const GuideStats& stats) {
      keep(request, table, stats);
    };
  return start;
}

// As jobs do, but that a table of the scene under other light serves too.
Status LiveSessions::choose_table(const std::string& wanted, LiveSession::Start& start) {
  Result<StartingGuide> chosen = server::choose_table(
      stores_.tables, *start.scene, start.settings.render, {wanted, /*must_fit=*/false},
      [](const std::string& text) { spdlog::warn("a live session begins without: {}", text); });
  if (!chosen.ok())
    return wanted == "auto" ? chosen.error()
                            : Error{ErrorCode::kInvalid, chosen.error().message, "/table"};
  start.guide = std::move(chosen.value().guide);
  start.table = std::move(chosen.value().table);
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
