#include "server/api/handlers_passes.h"

#include "core/base/file.h"
#include "core/base/turn.h"
#include "core/image/exposure.h"
#include "core/image/layer_view.h"
#include "server/http/query.h"
#include "server/http/reply.h"

namespace qray::server {
namespace {

constexpr uint64_t kMaxFileBytes = uint64_t{1} << 36;

bool asks_for_passes(const JobRequest& request) {
  return request.given(field::kPasses) ||
         request.given(field::kLightGroups).value_or("none") != "none";
}

std::string name_of(const JobRecord& job, int frame) {
  return job.id.text() + (frame > 0 ? "-frame-" + std::to_string(frame) : "") + "-passes.exr";
}

}  // namespace

void PassHandlers::add_to(Router& router) {
  router.add("GET", "/v1/jobs/{id}/passes",
             [this](auto& req, auto& res, auto& id) { list(req, res, id); });
  router.add("GET", "/v1/jobs/{id}/passes.exr",
             [this](auto& req, auto& res, auto& id) { exr(req, res, id); });
  router.add("GET", "/v1/jobs/{id}/pass.png",
             [this](auto& req, auto& res, auto& id) { png(req, res, id); });
}

Result<std::filesystem::path> PassHandlers::file(const Request& req, const JobRecord& job) const {
  const Result<int> frame = PictureSource::frame(req, job);
  if (!frame.ok()) return frame.error();
  if (!asks_for_passes(job.request))
    return Error{ErrorCode::kNotFound, "this job was not asked for passes", ""};
  std::filesystem::path path = stores_.results.passes_file({job.id, frame.value()});
  std::error_code ec;
  if (std::filesystem::exists(path, ec)) return path;
  return Error{ErrorCode::kConflict, "passes are made at the end of the job, and are not there",
               ""};
}

void PassHandlers::list(const Request& req, Response& res, const std::string& id) {
  const Result<JobRecord> job = stores_.jobs.find(id);
  if (!job.ok()) return reply_error(res, job.error());
  const Result<std::filesystem::path> path = file(req, job.value());
  if (!path.ok()) return reply_error(res, path.error());
  const Result<std::vector<std::string>> names = read_layer_names(path.value());
  if (!names.ok()) return reply_error(res, names.error());
  reply_tagged(req, res, proto::passes_to_json(id, names.value()));
}

void PassHandlers::exr(const Request& req, Response& res, const std::string& id) {
  const Result<JobRecord> job = stores_.jobs.find(id);
  if (!job.ok()) return reply_error(res, job.error());
  const Result<std::filesystem::path> path = file(req, job.value());
  if (!path.ok()) return reply_error(res, path.error());
  Result<MappedFile> mapped = MappedFile::open(path.value(), kMaxFileBytes);
  if (!mapped.ok()) return reply_error(res, mapped.error());
  reply_file(res, std::move(mapped).value(),
             name_of(job.value(), PictureSource::frame(req, job.value()).value()), "image/x-exr");
}

void PassHandlers::png(const Request& req, Response& res, const std::string& id) {
  const Result<JobRecord> job = stores_.jobs.find(id);
  if (!job.ok()) return reply_error(res, job.error());
  const Result<float> exposure = query_number(req, "exposure", -kMaxExposure, kMaxExposure, 0.0f);
  if (!exposure.ok()) return reply_error(res, exposure.error());
  const Result<std::filesystem::path> path = file(req, job.value());
  if (!path.ok()) return reply_error(res, path.error());
  const Turn turn(encoders_);
  if (!turn.mine()) return reply_problem(res, kTooManyPictures);
  const Result<PictureLayer> layer = read_layer(path.value(), req.get_param_value("layer"));
  if (!layer.ok()) {
    if (layer.error().code != ErrorCode::kNotFound) return reply_error(res, layer.error());
    return reply_error(
        res, {ErrorCode::kInvalid,
              "expected a layer that .../passes lists, got '" + req.get_param_value("layer") + "'",
              "/layer"});
  }
  Image view = layer_view(layer.value());
  if (layer.value().channels == "RGB") expose(view, exposure.value());
  const Result<Bytes> bytes = encode_image(ImageFormat::kPng, view);
  if (!bytes.ok()) return reply_error(res, bytes.error());
  reply_tagged(req, res, bytes.value(), "image/png");
}

}  // namespace qray::server
