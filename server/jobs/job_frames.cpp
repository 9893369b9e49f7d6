#include "server/jobs/job_frames.h"

#include <algorithm>

#include "core/job/stats_json.h"
#include "proto/events.h"

namespace qray::server {
namespace {

constexpr std::string_view kWaiting = "waiting";
constexpr std::string_view kDone = "done";
constexpr std::string_view kCanceled = "canceled";

}  // namespace

JobFrames::JobFrames(const Uses& uses, JobId id, const std::vector<JobFrame>& frames, bool goes_on,
                     std::stop_token stop)
    : uses_(uses), id_(id), stop_(std::move(stop)), infos_(frames.size()) {
  for (size_t i = 0; i < frames.size(); ++i) {
    infos_[i].frame = static_cast<int>(i);
    infos_[i].camera = frames[i].name;
    infos_[i].state = kWaiting;
  }
  if (goes_on) take_up();
  (void)keep();  // lost, it only tells less until the first turn has ended
}

// What is kept of them from before.
void JobFrames::take_up() {
  const Result<std::string> kept = uses_.results.load_frames(id_);
  if (!kept.ok()) return;
  std::vector<proto::FrameInfo> before = proto::parse_frame_infos(kept.value());
  if (before.size() != infos_.size()) return;
  infos_ = std::move(before);
  const bool more_is_asked = std::all_of(infos_.begin(), infos_.end(), [](const auto& one) {
    return one.state == kDone || one.state == kCanceled;
  });
  for (proto::FrameInfo& one : infos_) {
    if (!more_is_asked && one.state == kDone) continue;
    one.state = kWaiting;
    one.fraction = 0;
  }
}

RenderObserver& JobFrames::begin_turn(int frame, std::shared_ptr<Film> film) {
  RunningJob::Others others;
  others.share = 1 / static_cast<double>(infos_.size());
  for (const proto::FrameInfo& other : infos_) {
    if (other.frame == frame) continue;
    others.fraction += others.share * other.fraction;
    others.seconds += other.seconds;
  }
  uses_.running.show(frame, std::move(film), others);
  return uses_.running;
}

Status JobFrames::end_turn(int frame, const FrameProgress& progress, const Film& film,
                           const JobResult& result) {
  if (!uses_.lease.holds())
    return Error{ErrorCode::kCanceled, "another process may have the job by now", ""};
  last_ = result.stats;
  const PictureKey key(id_, frame);
  if (result.recovered)
    if (Status s = uses_.results.save_recovered(key, *result.recovered, result.recovered_metadata);
        !s.ok())
      return s;
  if (result.passes)
    if (Status s = uses_.results.save_passes(key, *result.passes); !s.ok()) return s;
  if (Status s = uses_.results.save(key, film, result.metadata); !s.ok()) return s;
  proto::FrameInfo& now = info(frame);
  now.state = kDone;
  now.fraction = 1;
  now.samples = progress.samples;
  now.seconds = progress.seconds;
  now.noise = progress.noise;
  RenderStats stats = result.stats;
  stats.guide_passes.clear();  // of a thousand frames they would be most of the file
  now.stats_json = stats_json(stats, /*indent=*/false);
  const std::string name = id_.text();
  uses_.jobs.publish_hint({0, name, "frame", proto::frame_event(name, now)});
  return keep();
}

bool JobFrames::wanted(int frame) {
  if (const auto at = uses_.results.canceled_frames_at(id_); at != canceled_at_) {
    canceled_ = uses_.results.canceled_frames(id_);
    canceled_at_ = at;
  }
  return !canceled_.contains(frame);
}

Status JobFrames::left_out(int frame, const Film* film) {
  if (!uses_.lease.holds())
    return Error{ErrorCode::kCanceled, "another process may have the job by now", ""};
  if (film && film->version() > 0)
    if (Status s = uses_.results.save({id_, frame}, *film, {{"unfinished", "true"}}); !s.ok())
      return s;
  proto::FrameInfo& now = info(frame);
  now.state = kCanceled;
  now.fraction = 1;  // of the job's work nothing of it is left
  const std::string name = id_.text();
  uses_.jobs.publish_hint({0, name, "frame", proto::frame_event(name, now)});
  return keep();
}

Status JobFrames::keep() {
  if (!uses_.lease.holds()) return {};
  return uses_.results.save_frames(id_, proto::frames_to_json(id_.text(), infos_));
}

Status JobFrames::save(int frame, int turn, const WriteState& write) {
  return uses_.checkpoints.save_frame(
      id_, frame, turn, write, [this] { return stop_.stop_requested() || !uses_.lease.holds(); });
}

Status JobFrames::load(int frame, int turn, const std::function<bool(SnapshotReader&)>& read) {
  const Result<Checkpoint> kept = uses_.checkpoints.load_frame(id_, frame, turn);
  if (!kept.ok())
    return Error{ErrorCode::kCorrupt, "the state of a frame is of no use: " + kept.error().text(),
                 "frame " + std::to_string(frame)};
  SnapshotReader in = kept.value().state();
  if (read(in)) return {};
  return Error{ErrorCode::kCorrupt, "not the state of this frame",
               "frame " + std::to_string(frame)};
}

}  // namespace qray::server
