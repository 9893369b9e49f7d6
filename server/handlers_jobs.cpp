#include "server/handlers_jobs.h"

#include <spdlog/spdlog.h>

#include <cmath>

#include "core/base/file.h"
#include "core/guide/surface_grid.h"
#include "core/recover/included_networks.h"
#include "server/jobs/job_settings.h"
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

JobHandlers::JobHandlers(JobRunner& runner, Stores stores, const proto::RequestLimits& limits)
    : runner_(runner), stores_(stores), limits_(limits) {
  for (std::string_view name : method_names()) limits_.methods.emplace_back(name);
  limits_.max_grid = SurfaceGrid::kMaxGrid;
}

void JobHandlers::add_to(Router& router) {
  router.add("POST", "/v1/jobs", [this](auto& req, auto& res, auto&) { create(req, res); });
  router.add("GET", "/v1/jobs", [this](auto& req, auto& res, auto&) { list(req, res); });
  router.add("GET", "/v1/jobs/{id}", [this](auto&, auto& res, auto& id) { get(res, id); });
  router.add("POST", "/v1/jobs/{id}/cancel",
             [this](auto&, auto& res, auto& id) { cancel(res, id); });
  router.add("GET", "/v1/jobs/{id}/tiles",
             [this](auto& req, auto& res, auto& id) { tiles(req, res, id); });
  router.add("GET", "/v1/jobs/{id}/image.exr",
             [this](auto& req, auto& res, auto& id) { exr(req, res, id); });
  router.add("GET", "/v1/jobs/{id}/image.png",
             [this](auto& req, auto& res, auto& id) { png(req, res, id); });
}

proto::JobInfo JobHandlers::info(const JobRecord& job) const {
  proto::JobInfo info = job.info();
  if (is_running(job.state)) {
    if (const auto live = runner_.live(job.id)) info.progress = live->progress();
  }
  return info;
}

Result<JobRecord> JobHandlers::find(const std::string& id) const {
  const std::optional<JobId> parsed = JobId::parse(id);
  if (!parsed) return Error{ErrorCode::kNotFound, "no such job", ""};
  return stores_.jobs.get(*parsed);
}

// What the request names must be there; sizes that it leaves out are filled in for its answer.
std::optional<proto::Problem> JobHandlers::check_references(proto::JobRequest& request) {
  proto::Problem problem{422, "Wrong job request", "", {}};
  if (!stores_.scenes.has(request.scene)) {
    problem.errors.push_back({"/scene", "no scene of this name: see /v1/scenes"});
  } else if (!request.width || !request.height) {
    if (const auto size = stores_.scenes.size(request.scene)) {
      if (!request.width) request.width = size->first;
      if (!request.height) request.height = size->second;
    }
  }
  // The size that it gives itself was looked at before, that of its scene was not.
  const int64_t pixels_wanted = int64_t{request.width.value_or(1)} * request.height.value_or(1);
  if (pixels_wanted > limits_.max_pixels) {
    problem.errors.push_back({"/width", "expected at most " + std::to_string(limits_.max_pixels) +
                                            " pixels in all, got " +
                                            std::to_string(pixels_wanted)});
  }
  if (request.table != "auto" && request.table != "none") {
    const Result<proto::TableInfo> table = stores_.tables.find(request.table);
    if (!table.ok()) {
      problem.errors.push_back({"/table", "no table with this id: see /v1/tables"});
    } else if (table.value().method != table_method(request.method)) {
      problem.errors.push_back({"/table", "a table of method " + table.value().method +
                                              " does not serve " + request.method});
    }
  }
  const std::optional<Pixels> pixels = pixels_named(request.pixels);
  for (const auto& [pointer, side] :
       {std::pair{"/width", request.width}, {"/height", request.height}})
    if (pixels != Pixels::kAll && side && *side % 2 != 0)
      problem.errors.push_back(
          {pointer,
           "expected an even number for a quarter of the pixels, got " + std::to_string(*side)});
  const bool own = !included_network(request.recover).ok() && request.recover != "auto" &&
                   request.recover != "none";
  if (own && !stores_.weights.find(request.recover).ok())
    problem.errors.push_back({"/recover", "no weights with this id: see /v1/weights"});
  if (problem.errors.empty()) return std::nullopt;
  problem.detail = problem.errors.front().pointer + ": " + problem.errors.front().detail;
  return problem;
}

void JobHandlers::create(const Request& req, Response& res) {
  if (!is_json(req)) return reply_not_json(res);
  auto parsed = proto::parse_job_request(req.body, limits_);
  if (const auto* problem = std::get_if<proto::Problem>(&parsed)) {
    return reply_problem(res, *problem);
  }
  proto::JobRequest request = std::get<proto::JobRequest>(std::move(parsed));
  if (const auto problem = check_references(request)) return reply_problem(res, *problem);
  fill_defaults(request);
  Result<JobRecord> job = runner_.submit(request);
  if (!job.ok()) return reply_error(res, job.error());
  res.set_header("Location", "/v1/jobs/" + job.value().id.text());
  reply_json(res, 202, proto::job_to_json(info(job.value())));
}

void JobHandlers::list(const Request& req, Response& res) {
  const Result<int> limit = query_number(req, "limit", 1, 200, 50);
  if (!limit.ok()) return reply_error(res, limit.error());
  std::optional<JobId> before;
  if (req.has_param("before")) {
    before = JobId::parse(req.get_param_value("before"));
    if (!before) return reply_error(res, {ErrorCode::kInvalid, "expected a job's id", "/before"});
  }
  const size_t wanted = static_cast<size_t>(limit.value());
  Result<std::vector<JobRecord>> jobs = stores_.jobs.list(wanted + 1, before);
  if (!jobs.ok()) return reply_error(res, jobs.error());
  std::vector<proto::JobInfo> infos;
  for (const JobRecord& job : jobs.value()) {
    if (infos.size() < wanted) infos.push_back(info(job));
  }
  const std::string next = jobs.value().size() > wanted ? infos.back().id : "";
  reply_json(res, 200, proto::job_list_to_json(infos, next));
}

void JobHandlers::get(Response& res, const std::string& id) {
  const Result<JobRecord> job = find(id);
  if (!job.ok()) return reply_error(res, job.error());
  reply_json(res, 200, proto::job_to_json(info(job.value())));
}

void JobHandlers::cancel(Response& res, const std::string& id) {
  const Result<JobRecord> job = find(id);
  if (!job.ok()) return reply_error(res, job.error());
  const Result<JobRecord> canceled = runner_.cancel(job.value().id);
  if (!canceled.ok()) return reply_error(res, canceled.error());
  reply_json(res, 202, proto::job_to_json(info(canceled.value())));
}

void JobHandlers::tiles(const Request& req, Response& res, const std::string& id) {
  const Result<JobRecord> job = find(id);
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

Result<JobHandlers::Which> JobHandlers::which_picture(const Request& req, const JobRecord& job,
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

Result<Image> JobHandlers::image_of(const JobRecord& job) {
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

void JobHandlers::exr(const Request& req, Response& res, const std::string& id) {
  const Result<JobRecord> job = find(id);
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
    if (file.ok()) return reply_bytes(res, file.value(), "image/x-exr");
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
  reply_bytes(res, bytes.value(), "image/x-exr");
}

void JobHandlers::png(const Request& req, Response& res, const std::string& id) {
  const Result<JobRecord> job = find(id);
  if (!job.ok()) return reply_error(res, job.error());
  const Result<float> exposure = query_number(req, "exposure", -32.0f, 32.0f, 0.0f);
  if (!exposure.ok()) return reply_error(res, exposure.error());
  const Turn turn(encoders_);
  if (!turn.mine()) return reply_problem(res, {503, "Busy", "too many pictures at once", {}});
  const Result<Which> which = which_picture(req, job.value(), /*best=*/true);
  if (!which.ok()) return reply_error(res, which.error());
  Result<Image> image = which.value() == Which::kRecovered
                            ? stores_.results.load_recovered(job.value().id)
                            : image_of(job.value());
  if (!image.ok()) return reply_error(res, image.error());
  const float scale = std::exp2(exposure.value());
  if (scale != 1) {
    for (float& v : image.value().data()) v *= scale;
  }
  const Result<Bytes> bytes = encode_image(ImageFormat::kPng, image.value());
  if (!bytes.ok()) return reply_error(res, bytes.error());
  reply_bytes(res, bytes.value(), "image/png");
}

}  // namespace qray::server
