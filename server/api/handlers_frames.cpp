#include "server/api/handlers_frames.h"

#include "core/base/file.h"
#include "core/base/temporary_folder.h"
#include "core/base/turn.h"
#include "core/image/animation.h"
#include "core/image/exposure.h"
#include "core/settings/frames.h"
#include "server/http/query.h"
#include "server/http/reply.h"
#include "server/imports/zip_files.h"

namespace qray::server {
namespace fs = std::filesystem;
namespace {

constexpr uint64_t kMaxAnswerBytes = uint64_t{1} << 36;
constexpr double kUsualPerSecond = 12;

Error no_room() { return {ErrorCode::kIo, "no room to make this file", ""}; }

// A file that was made for this answer; it may be removed as soon as this returns.
void reply_made(httplib::Response& res, const fs::path& path, const std::string& name,
                const char* type) {
  Result<MappedFile> file = MappedFile::open(path, kMaxAnswerBytes);
  if (!file.ok()) return reply_error(res, file.error());
  reply_file(res, std::move(file).value(), name, type);
}

Result<float> exposure_of(const httplib::Request& req) {
  return query_number(req, "exposure", -kMaxExposure, kMaxExposure, 0.0f);
}

}  // namespace

FrameHandlers::FrameHandlers(JobRunner& runner, const PictureSource& pictures, Stores stores,
                             const fs::path& data, std::counting_semaphore<>& encoders)
    : runner_(runner),
      pictures_(pictures),
      stores_(stores),
      data_(data / "answers"),
      encoders_(encoders) {
  std::error_code ec;
  fs::remove_all(data_, ec);  // what a killed server left
}

void FrameHandlers::add_to(Router& router) {
  router.add("GET", "/v1/jobs/{id}/frames",
             [this](auto& req, auto& res, auto& id) { list(req, res, id); });
  router.add("POST", "/v1/jobs/{id}/frames/cancel",
             [this](auto& req, auto& res, auto& id) { cancel(req, res, id); });
  router.add("POST", "/v1/jobs/{id}/frames/retry",
             [this](auto& req, auto& res, auto& id) { retry(req, res, id); });
  router.add("GET", "/v1/jobs/{id}/frames.zip",
             [this](auto& req, auto& res, auto& id) { archive(req, res, id); });
  router.add("GET", "/v1/jobs/{id}/frames.gif", [this](auto& req, auto& res, auto& id) {
    animation(req, res, id, ".gif", "image/gif");
  });
  router.add("GET", "/v1/jobs/{id}/frames.mp4", [this](auto& req, auto& res, auto& id) {
    animation(req, res, id, ".mp4", "video/mp4");
  });
}

// A job that has not run yet has frames that wait.
FrameHandlers::Frames FrameHandlers::frames_of_job(const JobRecord& job) const {
  Frames frames = kept_frames(job);
  for (const int frame : stores_.results.canceled_frames(job.id))
    if (static_cast<size_t>(frame) < frames.size())
      frames[static_cast<size_t>(frame)].state = "canceled";
  return frames;
}

FrameHandlers::Frames FrameHandlers::kept_frames(const JobRecord& job) const {
  if (const Result<std::string> kept = stores_.results.load_frames(job.id); kept.ok())
    if (Frames frames = proto::parse_frame_infos(kept.value()); !frames.empty()) return frames;
  Frames frames;
  if (!asks_for_frames(job.request)) return frames;
  for (int i = 0; i < frame_count(job.request).value_or(0); ++i) {
    proto::FrameInfo& info = frames.emplace_back();
    info.frame = i;
    info.state = "waiting";
    info.camera = camera_name(job.request, i);
  }
  return frames;
}

void FrameHandlers::list(const Request& req, Response& res, const std::string& id) {
  const Result<JobRecord> job = stores_.jobs.find(id);
  if (!job.ok()) return reply_error(res, job.error());
  Frames frames = frames_of_job(job.value());
  if (const std::optional<int> frame = pictures_.frame_under_way(job.value()))
    if (static_cast<size_t>(*frame) < frames.size() &&
        frames[static_cast<size_t>(*frame)].state != "canceled")
      frames[static_cast<size_t>(*frame)].state = "rendering";
  reply_tagged(req, res, proto::frames_to_json(job.value().id.text(), frames));
}

Result<FrameHandlers::One> FrameHandlers::one(const Request& req, const std::string& id) const {
  const Result<JobRecord> job = stores_.jobs.find(id);
  if (!job.ok()) return job.error();
  if (!asks_for_frames(job.value().request))
    return Error{ErrorCode::kNotFound, "this job has no frames", ""};
  if (!req.has_param("frame"))
    return Error{ErrorCode::kInvalid, "expected the number of a frame, got nothing", "/frame"};
  const Result<int> number = PictureSource::frame(req, job.value());
  if (!number.ok()) return number.error();
  const Frames frames = frames_of_job(job.value());
  const auto at = static_cast<size_t>(number.value());
  if (at >= frames.size())  // the scene, which is not loaded yet, says how many there are
    return Error{ErrorCode::kConflict, "this job's frames are not known yet", ""};
  return One{job.value(), frames[at]};
}

void FrameHandlers::cancel(const Request& req, Response& res, const std::string& id) {
  std::lock_guard lock(canceled_mutex_);
  const Result<One> found = one(req, id);
  if (!found.ok()) return reply_error(res, found.error());
  const JobId job = found.value().job.id;
  if (has_ended(found.value().job.state) || found.value().frame.state == "done")
    return reply_error(res, {ErrorCode::kConflict, "this frame has ended", ""});
  std::set<int> canceled = stores_.results.canceled_frames(job);
  canceled.insert(found.value().frame.frame);
  if (Status s = stores_.results.save_canceled_frames(job, canceled); !s.ok())
    return reply_error(res, s.error());
  reply_json(res, 202, proto::frames_to_json(job.text(), frames_of_job(found.value().job)));
}

void FrameHandlers::retry(const Request& req, Response& res, const std::string& id) {
  std::lock_guard lock(canceled_mutex_);
  const Result<One> found = one(req, id);
  if (!found.ok()) return reply_error(res, found.error());
  const JobRecord& job = found.value().job;
  std::set<int> canceled = stores_.results.canceled_frames(job.id);
  if (canceled.erase(found.value().frame.frame) == 0)
    return reply_error(res, {ErrorCode::kConflict, "this frame was not canceled", ""});
  if (has_ended(job.state))
    if (const Result<JobRecord> again = runner_.go_on(job.id); !again.ok())
      return reply_error(res, again.error());
  if (Status s = stores_.results.save_canceled_frames(job.id, canceled); !s.ok())
    return reply_error(res, s.error());
  reply_json(res, 202, proto::frames_to_json(job.id.text(), frames_of_job(job)));
}

Result<Image> FrameHandlers::picture(const JobRecord& job, int frame, float exposure) const {
  using Which = PictureSource::Which;
  const bool recovered = stores_.results.has_recovered({job.id, frame});
  Result<Image> image = pictures_.image(
      job, Which{recovered ? Which::Kind::kRecovered : Which::Kind::kSampled, 0, frame});
  if (image.ok()) expose(image.value(), exposure);
  return image;
}

// Frames that have no picture yet are left out.
void FrameHandlers::archive(const Request& req, Response& res, const std::string& id) {
  const Result<JobRecord> job = stores_.jobs.find(id);
  if (!job.ok()) return reply_error(res, job.error());
  const std::string format = req.has_param("format") ? req.get_param_value("format") : "png";
  if (format != "png" && format != "exr")
    return reply_error(res, {ErrorCode::kInvalid, "expected png or exr", "/format"});
  const Result<float> exposure = exposure_of(req);
  if (!exposure.ok()) return reply_error(res, exposure.error());
  const Turn turn(encoders_);
  if (!turn.mine()) return reply_problem(res, kTooManyPictures);
  const TemporaryFolder scratch(data_, "answer-");
  if (!scratch.ok()) return reply_error(res, no_room());
  std::vector<fs::path> files;
  for (const proto::FrameInfo& frame : frames_of_job(job.value())) {
    const Result<Image> image =
        picture(job.value(), frame.frame, format == "exr" ? 0 : exposure.value());
    if (!image.ok()) continue;
    files.push_back(scratch / frame_file_name(frame.frame, format));
    if (Status s = write_image(files.back(), image.value()); !s.ok())
      return reply_error(res, s.error());
  }
  if (files.empty())
    return reply_error(res, {ErrorCode::kConflict, "none of this job's frames has a picture", ""});
  const std::string name = job.value().id.text() + "-frames.zip";
  if (Status s = zip_files(scratch / name, files); !s.ok()) return reply_error(res, s.error());
  reply_made(res, scratch / name, name, "application/zip");
}

void FrameHandlers::animation(const Request& req, Response& res, const std::string& id,
                              const char* extension, const char* type) {
  const Result<JobRecord> job = stores_.jobs.find(id);
  if (!job.ok()) return reply_error(res, job.error());
  const Result<double> per_second =
      query_number(req, "fps", kLeastPerSecond, kMostPerSecond, kUsualPerSecond);
  if (!per_second.ok()) return reply_error(res, per_second.error());
  const Result<float> exposure = exposure_of(req);
  if (!exposure.ok()) return reply_error(res, exposure.error());
  const Turn turn(encoders_);
  if (!turn.mine()) return reply_problem(res, kTooManyPictures);
  const Frames frames = frames_of_job(job.value());
  if (frames.empty()) return reply_error(res, {ErrorCode::kNotFound, "this job has no frames", ""});
  const TemporaryFolder scratch(data_, "answer-");
  if (!scratch.ok()) return reply_error(res, no_room());
  const std::string name = job.value().id.text() + extension;
  const Animation all{static_cast<int>(frames.size()), per_second.value(),
                      [&](int frame) { return picture(job.value(), frame, exposure.value()); }};
  if (Status s = write_animation(scratch / name, all); !s.ok()) {
    Error error = s.error();
    error.where.clear();
    return reply_error(res, error);
  }
  reply_made(res, scratch / name, name, type);
}

}  // namespace qray::server
