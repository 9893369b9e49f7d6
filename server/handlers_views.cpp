#include "server/handlers_views.h"

#include <spdlog/spdlog.h>

#include "core/image/image_io.h"
#include "core/render/debug_view.h"
#include "core/render/lobe_view.h"
#include "server/jobs/job_settings.h"
#include "server/query.h"
#include "server/reply.h"
#include "server/turn.h"

namespace qray::server {
namespace {

constexpr int kMaxSide = 512;  // pixels, of a view
constexpr int kViewSamples = 4;

Error conflict(std::string message) { return {ErrorCode::kConflict, std::move(message), ""}; }

void reply_png(httplib::Response& res, const Image& image, const ImageMetadata& metadata) {
  const Result<Bytes> bytes = encode_image(ImageFormat::kPng, image, metadata);
  if (!bytes.ok()) return reply_error(res, bytes.error());
  reply_bytes(res, bytes.value(), "image/png");
}

Result<int> coordinate(const httplib::Request& req, const char* name, int size) {
  if (!req.has_param(name))
    return Error{ErrorCode::kInvalid, "expected a pixel of the job's picture",
                 std::string("/") + name};
  return query_number(req, name, 0, size - 1, 0);
}

void shrink(RenderSettings& settings) {
  const int side = std::max(settings.width, settings.height);
  if (side <= kMaxSide) return;
  settings.width = std::max(1, settings.width * kMaxSide / side);
  settings.height = std::max(1, settings.height * kMaxSide / side);
}

}  // namespace

struct ViewHandlers::Shown {
  std::shared_ptr<const PreparedScene> scene;
  RenderSettings settings;
  std::unique_ptr<Guide> guide;
};

void ViewHandlers::add_to(Router& router) {
  router.add("GET", "/v1/jobs/{id}/view.png",
             [this](auto& req, auto& res, auto& id) { view(req, res, id); });
  router.add("GET", "/v1/jobs/{id}/lobe.png",
             [this](auto& req, auto& res, auto& id) { lobe(req, res, id); });
}

Result<JobRecord> ViewHandlers::find(const std::string& id) const {
  Result<JobRecord> job = stores_.jobs.find(id);
  if (!job.ok()) return job;
  if (job.value().state != JobState::kSucceeded)
    return conflict("the job has not succeeded: it is " +
                    std::string(to_string(job.value().state)));
  if (job.value().table_out.empty()) return conflict("the job left no table");
  return job;
}

// Whatever fails here worked when the job ran: scene or table are not what they were.
Result<ViewHandlers::Shown> ViewHandlers::load(const JobRecord& job) {
  Shown shown;
  Result<std::shared_ptr<const PreparedScene>> scene = stores_.scenes.prepare(job.request.scene);
  if (!scene.ok()) return conflict("the job's scene cannot be loaded any more");
  shown.scene = std::move(scene).value();
  shown.settings = settings_of(job.request, shown.scene->scene);
  shown.settings.max_table_bytes = stores_.tables.max_bytes();
  Result<TableFile> table = stores_.tables.load(job.table_out);
  if (!table.ok()) {
    spdlog::error("job={} {}", job.id.text(), table.error().text());
    return conflict("the job's table cannot be read any more");
  }
  if (!table_fits(table.value().header, shown.scene->hash))
    return conflict("the scene has changed since the job");
  Result<std::unique_ptr<Guide>> guide =
      load_guide(*shown.scene, shown.settings, std::move(table).value());
  if (!guide.ok())
    return conflict("the job's table cannot be used any more: " + guide.error().message);
  shown.guide = std::move(guide).value();
  return shown;
}

void ViewHandlers::view(const Request& req, Response& res, const std::string& id) {
  const Result<JobRecord> job = find(id);
  if (!job.ok()) return reply_error(res, job.error());
  const std::string name = req.has_param("view") ? req.get_param_value("view") : "";
  const std::optional<DebugView> view = parse_debug_view(name);
  if (!view || !shows_guide(*view))
    return reply_error(res, {ErrorCode::kInvalid, "expected state, beta or gain", "/view"});
  const Turn turn(turns_);
  if (!turn.mine()) return reply_problem(res, {503, "Busy", "too many pictures at once", {}});
  Result<Shown> shown = load(job.value());
  if (!shown.ok()) return reply_error(res, shown.error());
  RenderSettings& settings = shown.value().settings;
  shrink(settings);
  TaskPool pool(1);
  const Result<Image> image =
      render_debug_view(*shown.value().scene, settings, *view, shown.value().guide.get(),
                        kViewSamples, pool, stop_.get_token());
  if (!image.ok()) return reply_error(res, image.error());
  reply_png(res, image.value(), {{"view", name}, {"scale", std::string(scale_of(*view))}});
}

void ViewHandlers::lobe(const Request& req, Response& res, const std::string& id) {
  const Result<JobRecord> job = find(id);
  if (!job.ok()) return reply_error(res, job.error());
  const Result<int> x = coordinate(req, "x", job.value().request.width.value_or(1));
  if (!x.ok()) return reply_error(res, x.error());
  const Result<int> y = coordinate(req, "y", job.value().request.height.value_or(1));
  if (!y.ok()) return reply_error(res, y.error());
  const Turn turn(turns_);
  if (!turn.mine()) return reply_problem(res, {503, "Busy", "too many pictures at once", {}});
  const Result<Shown> shown = load(job.value());
  if (!shown.ok()) return reply_error(res, shown.error());
  const Result<LobeView> view = render_lobe_view(*shown.value().scene, shown.value().settings,
                                                 *shown.value().guide, x.value(), y.value());
  if (!view.ok()) return reply_error(res, view.error());
  reply_png(res, view.value().image, {{"view", "lobe"}, {"scale", std::string(kLobeScale)}});
}

}  // namespace qray::server
