#include "server/live/live_session.h"

#include <spdlog/spdlog.h>

#include "core/live/lights.h"
#include "core/live/walls.h"
#include "core/scene/validate.h"
#include "core/settings/job_settings.h"

namespace qray::server {
namespace {

constexpr double kFirstReaderSeconds = 10, kNoReaderSeconds = 1;
constexpr double kEnoughSamples =
    4096;  // a pixel: a picture that nobody can tell from a better one
constexpr std::chrono::milliseconds kLook{100};

LiveSwitches switches_of(const proto::LiveSwitchesRequest& s) {
  return {s.learning, s.recovery, s.reprojection};
}

std::array<double, 3> array_of(Vec3 v) {
  return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}

CameraRequest request_of(const Camera& c) {
  return {array_of(c.position),
          array_of(c.target),
          array_of(c.up),
          static_cast<double>(c.vertical_fov_deg),
          static_cast<double>(c.aperture_radius),
          static_cast<double>(c.focus_distance),
          std::string(name_of(c.projection)),
          static_cast<double>(c.height)};
}

std::string mix_of(const Scene& scene, const std::vector<double>& factors) {
  const Result<std::string> mix = mix_of_lights(scene, factors);
  return mix.ok() ? mix.value() : "";
}

std::vector<std::pair<std::string, CameraRequest>> cameras_of(const Scene& scene) {
  std::vector<std::pair<std::string, CameraRequest>> cameras;
  for (const NamedCamera& named : scene.cameras)
    cameras.emplace_back(named.name, request_of(named.camera));
  return cameras;
}

}  // namespace

LiveSession::LiveSession(Start start, const TaskPool& threads, const Clock& clock)
    : start_(std::move(start)),
      pool_(threads, 1),
      clock_(clock),
      scene_camera_(start_.scene->scene.camera),
      lights_(light_names(start_.scene->scene)) {
  wanted_.camera = start_.settings.render.camera.value_or(scene_camera_);
  wanted_.switches = start_.request.switches;
  wanted_.factors.assign(lights_.size(), 1);
  last_call_ = reader_left_ = clock.seconds();
  view_ = std::make_unique<LiveView>(start_.scene, start_.settings, std::move(start_.guide),
                                     std::move(start_.network), pool_, clock);
  thread_ = std::jthread([this](std::stop_token stop) { run(stop); });
}

LiveSession::~LiveSession() { end(); }

void LiveSession::end() {
  thread_.request_stop();
  changed_.notify_all();
}

bool LiveSession::ended() const {
  std::lock_guard lock(mutex_);
  return ended_;
}

proto::LiveInfo LiveSession::info() const {
  std::lock_guard lock(mutex_);
  return {start_.id,
          start_.request.scene,
          start_.settings.render.method,
          start_.request.pixels,
          start_.recover,
          start_.table ? start_.table->id : std::string(),
          start_.settings.render.width,
          start_.settings.render.height,
          start_.settings.frame_seconds * 1000,
          wanted_.number,
          request_of(wanted_.camera),
          wanted_.switches,
          lights_,
          wanted_.factors,
          mix_of(start_.scene->scene, wanted_.factors),
          cameras_of(start_.scene->scene),
          newest_ ? newest_->frame.number : 0,
          readers_};
}

Result<proto::LiveCameraAnswer> LiveSession::set_camera(const proto::LiveCameraRequest& request) {
  Camera camera = camera_of(request.camera, scene_camera_);
  if (Status s = validate_camera(camera); !s.ok()) return s.error();
  std::lock_guard lock(mutex_);
  last_call_ = clock_.seconds();
  proto::LiveCameraAnswer answer{wanted_.number, {}};
  if (request.number <= wanted_.number) return answer;
  answer.number = request.number;
  if (request.walls) {
    const Vec3 stop = stop_before_walls(*start_.scene, wanted_.camera.position, camera.position);
    if (stop != camera.position) answer.position = array_of(stop);
    camera.position = stop;
  }
  if (Status s = validate_camera(camera); !s.ok()) return s.error();  // it came to its target
  wanted_.camera = camera;
  wanted_.number = request.number;
  changed_.notify_all();
  return answer;
}

void LiveSession::set_switches(const proto::LiveSwitchesRequest& switches) {
  std::lock_guard lock(mutex_);
  last_call_ = clock_.seconds();
  wanted_.switches = switches;
  changed_.notify_all();
}

void LiveSession::set_lights(std::vector<double> factors) {
  std::lock_guard lock(mutex_);
  last_call_ = clock_.seconds();
  wanted_.factors = std::move(factors);
  changed_.notify_all();
}

bool LiveSession::add_reader() {
  std::lock_guard lock(mutex_);
  if (ended_ || thread_.get_stop_token().stop_requested() || readers_ >= start_.readers)
    return false;
  ++readers_;
  had_reader_ = true;
  last_call_ = clock_.seconds();
  changed_.notify_all();
  return true;
}

void LiveSession::remove_reader() {
  std::lock_guard lock(mutex_);
  --readers_;
  reader_left_ = clock_.seconds();
}

std::shared_ptr<const ShownFrame> LiveSession::wait(uint64_t after,
                                                    std::chrono::milliseconds patience) const {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, patience,
                    [&] { return ended_ || (newest_ && newest_->frame.number > after); });
  return newest_ && newest_->frame.number > after ? newest_ : nullptr;
}

// False: nobody comes any more.
bool LiveSession::wait_for_reader(std::stop_token stop) {
  std::unique_lock lock(mutex_);
  for (;;) {
    const double now = clock_.seconds();
    if (stop.stop_requested() || now - last_call_ > start_.idle_seconds) return false;
    if (readers_ > 0) return true;
    if (now - reader_left_ > (had_reader_ ? kNoReaderSeconds : kFirstReaderSeconds)) return false;
    changed_.wait_for(lock, kLook);
  }
}

bool LiveSession::relight(const std::vector<double>& factors) {
  const std::vector<float> scales(factors.begin(), factors.end());
  Result<std::shared_ptr<const PreparedScene>> lit = with_lights(start_.scene, scales);
  if (!lit.ok()) {
    spdlog::error("live={} cannot switch lights: {}", start_.id, lit.error().text());
    return false;
  }
  view_->set_scene(std::move(lit).value());
  return true;
}

void LiveSession::frames(std::stop_token stop) {
  std::vector<double> lit(lights_.size(), 1);
  std::shared_ptr<const ShownFrame> last;
  Wanted shown;
  while (wait_for_reader(stop)) {
    Wanted wanted;
    {
      std::unique_lock lock(mutex_);
      if (last && last->frame.stage == LiveStage::kStill &&
          last->frame.samples_per_pixel >= kEnoughSamples) {
        const bool same = shown.number == wanted_.number && shown.factors == wanted_.factors &&
                          switches_of(shown.switches) == switches_of(wanted_.switches);
        if (same) {
          changed_.wait_for(lock, kLook);
          continue;
        }
      }
      wanted = wanted_;
    }
    if (wanted.factors != lit) {
      if (!relight(wanted.factors)) return;
      lit = wanted.factors;
    }
    view_->set_switches(switches_of(wanted.switches));
    view_->set_camera(wanted.camera);
    std::optional<LiveFrame> frame = view_->next_frame(stop);
    if (!frame) return;
    if (start_.made) start_.made(*frame);
    shown = wanted;
    last = std::make_shared<const ShownFrame>(ShownFrame{std::move(*frame), wanted.number});
    std::lock_guard lock(mutex_);
    newest_ = last;
    changed_.notify_all();
  }
}

void LiveSession::leave_table() {
  const Guide* guide = view_->guide();
  if (!guide || !start_.leave) return;
  const GuideStats stats = guide->stats();
  if (stats.samples_seen <= (start_.table ? start_.table->samples_seen : 0)) return;
  start_.leave(table_of(*guide, view_->scene().hash, start_.table), stats);
}

void LiveSession::run(std::stop_token stop) {
  try {
    frames(stop);
    leave_table();
  } catch (const std::exception& e) {  // no memory, above all
    spdlog::error("live={} exception: {}", start_.id, e.what());
  }
  view_.reset();
  std::lock_guard lock(mutex_);
  newest_.reset();
  start_.memory = {};
  ended_ = true;
  changed_.notify_all();
}

}  // namespace qray::server
