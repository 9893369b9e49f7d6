#include "server/handlers_pictures.h"

#include <spdlog/spdlog.h>

#include <cmath>
#include <filesystem>

#include "core/base/file.h"
#include "core/image/metrics.h"
#include "server/query.h"
#include "server/reply.h"
#include "server/tile_stream.h"
#include "server/turn.h"

namespace qray::server {
namespace {

constexpr int kTilesAtOnce = 256;  // 4 MB
constexpr uint64_t kMaxImageBytes = uint64_t{1} << 30;

Error nothing_yet() { return {ErrorCode::kConflict, "nothing of this job has been rendered", ""}; }

}  // namespace

void PictureHandlers::add_to(Router& router) {
  router.add("GET", "/v1/jobs/{id}/tiles",
             [this](auto& req, auto& res, auto& id) { tiles(req, res, id); });
  router.add("GET", "/v1/jobs/{id}/image.exr",
             [this](auto& req, auto& res, auto& id) { exr(req, res, id); });
  router.add("GET", "/v1/jobs/{id}/image.png",
             [this](auto& req, auto& res, auto& id) { png(req, res, id); });
  router.add("GET", "/v1/compare", [this](auto& req, auto& res, auto&) { compare(req, res); });
}

Result<Image> PictureHandlers::image_named(const Request& req, const char* parameter) {
  const auto named = [&](Error error) {
    error.where = std::string("/") + parameter;
    return error;
  };
  const Result<JobRecord> job = stores_.jobs.find(req.get_param_value(parameter));
  if (!job.ok()) return named(job.error());
  const Result<Which> which = which_picture(req, job.value(), /*best=*/true);
  if (!which.ok()) return which.error();
  Result<Image> image = image_of(job.value(), which.value());
  if (!image.ok() && image.error().code == ErrorCode::kConflict) return named(image.error());
  return image;
}

void PictureHandlers::compare(const Request& req, Response& res) {
  proto::Problem wrong{422, "Wrong request", "", {}};
  for (const char* parameter : {"a", "b", "ref"}) {
    const bool needed = std::string_view(parameter) != "ref";
    if ((needed || req.has_param(parameter)) && !JobId::parse(req.get_param_value(parameter)))
      wrong.errors.push_back({std::string("/") + parameter, "expected a job's id"});
  }
  if (const std::string picture = req.get_param_value("picture");
      req.has_param("picture") && picture != "sampled" && picture != "recovered")
    wrong.errors.push_back({"/picture", "expected sampled or recovered"});
  if (!wrong.errors.empty()) {
    wrong.detail = wrong.errors.front().pointer + ": " + wrong.errors.front().detail;
    return reply_problem(res, wrong);
  }
  const Turn turn(encoders_);
  if (!turn.mine()) return reply_problem(res, {503, "Busy", "too many pictures at once", {}});
  proto::Comparison comparison{
      req.get_param_value("a"), req.get_param_value("b"), req.get_param_value("ref"), {}, {}, {}};
  const Result<Image> a = image_named(req, "a");
  if (!a.ok()) return reply_error(res, a.error());
  const Result<Image> b = image_named(req, "b");
  if (!b.ok()) return reply_error(res, b.error());
  const auto judge = [&](const Image& picture, const Image& reference,
                         const char* pointer) -> Result<proto::PictureDifference> {
    const Result<ImageDifference> d = image_difference(picture, reference);
    if (!d.ok()) return Error{ErrorCode::kInvalid, d.error().message, pointer};
    return proto::PictureDifference{d.value().relmse, d.value().relmse_trimmed, d.value().flip,
                                    d.value().mean_ratio, d.value().max_abs};
  };
  Result<proto::PictureDifference> difference = judge(a.value(), b.value(), "/b");
  if (!difference.ok()) return reply_error(res, difference.error());
  comparison.difference = difference.value();
  if (req.has_param("ref")) {
    const Result<Image> ref = image_named(req, "ref");
    if (!ref.ok()) return reply_error(res, ref.error());
    for (const auto& [image, error] :
         {std::pair{&a.value(), &comparison.a_error}, {&b.value(), &comparison.b_error}}) {
      difference = judge(*image, ref.value(), "/ref");
      if (!difference.ok()) return reply_error(res, difference.error());
      *error = difference.value();
    }
  }
  reply_json(res, 200, proto::comparison_to_json(comparison));
}

void PictureHandlers::tiles(const Request& req, Response& res, const std::string& id) {
  const Result<JobRecord> job = stores_.jobs.find(id);
  if (!job.ok()) return reply_error(res, job.error());
  const Result<uint64_t> since = query_number<uint64_t>(req, "since", 0, UINT64_MAX, 0);
  if (!since.ok()) return reply_error(res, since.error());

  const Result<Which> which = which_picture(req, job.value(), /*best=*/false);
  if (!which.ok()) return reply_error(res, which.error());
  int width = job.value().request.width.value_or(0);
  int height = job.value().request.height.value_or(0);
  Film::Changes changes;
  if (const auto live = runner_.live(job.value().id)) {
    width = live->film().width();
    height = live->film().height();
    changes = live->film().tiles_since(since.value(), kTilesAtOnce);
  } else if (const auto picture = stores_.results.load(job.value().id); picture.ok()) {
    width = picture.value()->image.width();
    height = picture.value()->image.height();
    if (which.value() == Which::kRecovered) {
      Result<Image> recovered = stores_.results.load_recovered(job.value().id);
      if (!recovered.ok()) return reply_error(res, recovered.error());
      Picture whole = *picture.value();
      whole.image = std::move(recovered).value();
      changes = whole.tiles_since(since.value(), kTilesAtOnce);
    } else {
      changes = picture.value()->tiles_since(since.value(), kTilesAtOnce);
    }
  } else {
    changes.cursor = since.value();
  }
  reply_bytes(res, encode_tiles(width, height, changes), "application/octet-stream");
}

Result<PictureHandlers::Which> PictureHandlers::which_picture(const Request& req,
                                                              const JobRecord& job,
                                                              bool best) const {
  const std::string wanted = req.get_param_value("picture");
  std::error_code ec;
  const bool there = std::filesystem::exists(stores_.results.recovered_file(job.id), ec);
  if (wanted.empty()) return best && there ? Which::kRecovered : Which::kSampled;
  if (wanted == "sampled") return Which::kSampled;
  if (wanted != "recovered")
    return Error{ErrorCode::kInvalid, "expected sampled or recovered, got '" + wanted + "'",
                 "/picture"};
  if (there) return Which::kRecovered;
  if (job.request.recover == "none")
    return Error{ErrorCode::kNotFound, "this job's picture is not recovered", ""};
  return Error{ErrorCode::kConflict, "this job's picture has not been recovered yet", ""};
}

Result<Image> PictureHandlers::image_of(const JobRecord& job) {
  if (const auto live = runner_.live(job.id)) {
    if (live->film().version() == 0) return nothing_yet();
    return live->film().develop();
  }
  const auto picture = stores_.results.load(job.id);
  if (picture.ok()) return picture.value()->image;
  if (picture.error().code == ErrorCode::kNotFound) return nothing_yet();
  spdlog::error("job={} {}", job.id.text(), picture.error().text());
  return picture.error();
}

Result<Image> PictureHandlers::image_of(const JobRecord& job, Which which) {
  return which == Which::kRecovered ? stores_.results.load_recovered(job.id) : image_of(job);
}

void PictureHandlers::exr(const Request& req, Response& res, const std::string& id) {
  const Result<JobRecord> job = stores_.jobs.find(id);
  if (!job.ok()) return reply_error(res, job.error());
  const Turn turn(encoders_);
  if (!turn.mine()) return reply_problem(res, {503, "Busy", "too many pictures at once", {}});
  const JobRecord& record = job.value();
  const Result<Which> which = which_picture(req, record, /*best=*/true);
  if (!which.ok()) return reply_error(res, which.error());
  const bool recovered = which.value() == Which::kRecovered;
  if (recovered || !runner_.live(record.id)) {
    const Result<Bytes> file = read_file(recovered ? stores_.results.recovered_file(record.id)
                                                   : stores_.results.image_file(record.id),
                                         kMaxImageBytes);
    if (file.ok()) return reply_tagged(req, res, file.value(), "image/x-exr");
    if (recovered) return reply_error(res, file.error());
  }
  const Result<Image> image = image_of(record);
  if (!image.ok()) return reply_error(res, image.error());
  const Result<Bytes> bytes = encode_image(ImageFormat::kExr, image.value(),
                                           {{"scene", record.request.scene},
                                            {"method", record.request.method},
                                            {"seed", std::to_string(record.request.seed)},
                                            {"unfinished", "true"}});
  if (!bytes.ok()) return reply_error(res, bytes.error());
  reply_tagged(req, res, bytes.value(), "image/x-exr");
}

void PictureHandlers::png(const Request& req, Response& res, const std::string& id) {
  const Result<JobRecord> job = stores_.jobs.find(id);
  if (!job.ok()) return reply_error(res, job.error());
  const Result<float> exposure = query_number(req, "exposure", -32.0f, 32.0f, 0.0f);
  if (!exposure.ok()) return reply_error(res, exposure.error());
  const Turn turn(encoders_);
  if (!turn.mine()) return reply_problem(res, {503, "Busy", "too many pictures at once", {}});
  const Result<Which> which = which_picture(req, job.value(), /*best=*/true);
  if (!which.ok()) return reply_error(res, which.error());
  Result<Image> image = image_of(job.value(), which.value());
  if (!image.ok()) return reply_error(res, image.error());
  const float scale = std::exp2(exposure.value());
  if (scale != 1) {
    for (float& v : image.value().data()) v *= scale;
  }
  const Result<Bytes> bytes = encode_image(ImageFormat::kPng, image.value());
  if (!bytes.ok()) return reply_error(res, bytes.error());
  reply_tagged(req, res, bytes.value(), "image/png");
}

}  // namespace qray::server
