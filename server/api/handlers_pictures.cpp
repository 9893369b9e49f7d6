#include "server/api/handlers_pictures.h"

#include "core/base/file.h"
#include "core/base/turn.h"
#include "core/image/exposure.h"
#include "core/image/shrunk.h"
#include "server/http/query.h"
#include "server/http/reply.h"
#include "server/jobs/tile_stream.h"

namespace qray::server {
namespace {

constexpr int kLeastSide = 16, kMostSide = 8192;
constexpr int kTilesAtOnce = 256;  // 4 MB

// What a browser calls the picture that it keeps: "j000001.png", "j000001-moment-3.exr".
void name_file(httplib::Response& res, const std::string& id, const PictureSource::Which& which,
               const char* extension) {
  using enum PictureSource::Which::Kind;
  std::string name = id;
  if (which.kind == kMoment) name += "-moment-" + std::to_string(which.moment);
  if (which.frame > 0) name += "-frame-" + std::to_string(which.frame);
  res.set_header("Content-Disposition", "inline; filename=\"" + name + extension + "\"");
}

}  // namespace

void PictureHandlers::add_to(Router& router) {
  router.add("GET", "/v1/jobs/{id}/tiles",
             [this](auto& req, auto& res, auto& id) { tiles(req, res, id); });
  router.add("GET", "/v1/jobs/{id}/light-groups",
             [this](auto& req, auto& res, auto& id) { light_groups(req, res, id); });
  router.add("GET", "/v1/jobs/{id}/image.exr",
             [this](auto& req, auto& res, auto& id) { exr(req, res, id); });
  router.add("GET", "/v1/jobs/{id}/image.png",
             [this](auto& req, auto& res, auto& id) { png(req, res, id); });
}

// The group of lights whose light alone is asked for.
Result<std::optional<int>> PictureHandlers::group_of(const Request& req,
                                                     const JobRecord& job) const {
  if (!req.has_param("group")) return std::optional<int>();
  const int groups = static_cast<int>(pictures_.light_groups(job).size());
  if (groups == 0) return Error{ErrorCode::kNotFound, "this job keeps no groups apart", ""};
  const Result<int> group = query_number(req, "group", 0, groups - 1, 0);
  if (!group.ok()) return group.error();
  return std::optional(group.value());
}

void PictureHandlers::tiles(const Request& req, Response& res, const std::string& id) {
  const Result<JobRecord> job = stores_.jobs.find(id);
  if (!job.ok()) return reply_error(res, job.error());
  const Result<uint64_t> since = query_number<uint64_t>(req, "since", 0, UINT64_MAX, 0);
  if (!since.ok()) return reply_error(res, since.error());

  const auto which = pictures_.which(req, job.value(), /*best=*/false);
  if (!which.ok()) return reply_error(res, which.error());
  if (which.value().kind == Which::Kind::kMoment) {
    const Result<Bytes> answer = stores_.moments.picture(job.value().id, which.value().moment);
    if (!answer.ok()) return reply_error(res, answer.error());
    return reply_tagged(req, res, answer.value(), kBytesType);
  }
  int width = job.value().request.get(field::kWidth);
  int height = job.value().request.get(field::kHeight);
  const Result<std::optional<int>> group = group_of(req, job.value());
  if (!group.ok()) return reply_error(res, group.error());
  Film::Changes changes;
  const PictureKey key(job.value().id, which.value().frame);
  const auto running = runner_.running(key.job);
  const std::shared_ptr<const Film> film = running ? running->film(key.frame) : nullptr;
  if (film) {
    width = film->width();
    height = film->height();
    const std::optional<int> layer =
        group.value() ? std::optional(film->layers().group(*group.value())) : std::nullopt;
    changes = film->tiles_since(since.value(), kTilesAtOnce, layer);
  } else if (const auto picture = pictures_.sampled(job.value(), key.frame); picture.ok()) {
    width = picture.value()->image.width();
    height = picture.value()->image.height();
    if (group.value() || which.value().kind == Which::Kind::kRecovered) {
      Result<Image> other =
          group.value()
              ? pictures_.light_group(job.value(), key.frame, static_cast<size_t>(*group.value()))
              : stores_.results.load_recovered(key);
      if (!other.ok()) return reply_error(res, other.error());
      Picture whole = *picture.value();
      whole.image = std::move(other).value();
      changes = whole.tiles_since(since.value(), kTilesAtOnce);
    } else {
      changes = picture.value()->tiles_since(since.value(), kTilesAtOnce);
    }
  } else if (picture.error().code != ErrorCode::kConflict) {
    return reply_error(res, picture.error());
  } else {
    changes.cursor = since.value();  // nothing yet
  }
  reply_bytes(res, encode_tiles(width, height, changes), kBytesType);
}

void PictureHandlers::light_groups(const Request& req, Response& res, const std::string& id) {
  const Result<JobRecord> job = stores_.jobs.find(id);
  if (!job.ok()) return reply_error(res, job.error());
  reply_tagged(req, res, proto::light_groups_to_json(id, pictures_.light_groups(job.value())));
}

void PictureHandlers::exr(const Request& req, Response& res, const std::string& id) {
  const Result<JobRecord> job = stores_.jobs.find(id);
  if (!job.ok()) return reply_error(res, job.error());
  const Turn turn(encoders_);
  if (!turn.mine()) return reply_problem(res, {503, "Busy", "too many pictures at once", {}});
  const JobRecord& record = job.value();
  const auto which = pictures_.which(req, record, /*best=*/true);
  if (!which.ok()) return reply_error(res, which.error());
  name_file(res, record.id.text(), which.value(), ".exr");
  const bool recovered = which.value().kind == Which::Kind::kRecovered;
  const bool moment = which.value().kind == Which::Kind::kMoment;
  const auto running = runner_.running(record.id);
  const int frame = which.value().frame;
  const bool mix = !which.value().mix.empty();
  if (!mix && (recovered || (!moment && !(running && running->film(frame))))) {
    const Result<Bytes> file = stores_.results.load_file({record.id, frame}, recovered,
                                                         record.request.get(field::kHeight));
    if (file.ok()) return reply_tagged(req, res, file.value(), "image/x-exr");
    if (recovered || file.error().code != ErrorCode::kNotFound)
      return reply_error(res, file.error());
  }
  const Result<Image> image = pictures_.image(record, which.value());
  if (!image.ok()) return reply_error(res, image.error());
  ImageMetadata metadata = {{"scene", record.request.get(field::kScene)},
                            {"method", record.request.get(field::kMethod)},
                            {"seed", std::to_string(record.request.get(field::kSeed))}};
  if (mix) metadata["mix"] = req.get_param_value("mix");
  if (!has_ended(record.state) || !mix) metadata["unfinished"] = "true";
  const Result<Bytes> bytes = encode_image(ImageFormat::kExr, image.value(), metadata);
  if (!bytes.ok()) return reply_error(res, bytes.error());
  reply_tagged(req, res, bytes.value(), "image/x-exr");
}

void PictureHandlers::png(const Request& req, Response& res, const std::string& id) {
  const Result<JobRecord> job = stores_.jobs.find(id);
  if (!job.ok()) return reply_error(res, job.error());
  const bool automatic = req.get_param_value("exposure") == "auto";
  const Result<float> exposure =
      automatic ? Result<float>(0.0f)
                : query_number(req, "exposure", -kMaxExposure, kMaxExposure, 0.0f);
  if (!exposure.ok()) return reply_error(res, exposure.error());
  const Result<int> side = query_number(req, "side", kLeastSide, kMostSide, kMostSide);
  if (!side.ok()) return reply_error(res, side.error());
  const Turn turn(encoders_);
  if (!turn.mine()) return reply_problem(res, {503, "Busy", "too many pictures at once", {}});
  const auto which = pictures_.which(req, job.value(), /*best=*/true);
  if (!which.ok()) return reply_error(res, which.error());
  Result<Image> image = pictures_.image(job.value(), which.value());
  if (!image.ok()) return reply_error(res, image.error());
  name_file(res, job.value().id.text(), which.value(), ".png");
  const float stops = automatic ? auto_exposure(image.value()) : exposure.value();
  expose(image.value(), stops);
  if (req.has_param("side")) image = shrunk(image.value(), side.value());
  res.set_header("Qray-Exposure", std::to_string(stops));
  const Result<Bytes> bytes = encode_image(ImageFormat::kPng, image.value());
  if (!bytes.ok()) return reply_error(res, bytes.error());
  reply_tagged(req, res, bytes.value(), "image/png");
}

}  // namespace qray::server
