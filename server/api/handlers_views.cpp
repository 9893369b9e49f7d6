#include "server/api/handlers_views.h"

#include <spdlog/spdlog.h>

#include <cmath>

#include "core/base/turn.h"
#include "core/image/false_color.h"
#include "core/image/tonemap.h"
#include "core/render/lobe_view.h"
#include "core/render/pixel_probe.h"
#include "core/settings/frames.h"
#include "core/settings/job_settings.h"
#include "server/http/query.h"
#include "server/http/reply.h"

namespace qray::server {
namespace {

constexpr int kMaxSide = 512;  // pixels, of a view
constexpr int kViewSamples = 4;
constexpr size_t kMostKeptBytes = 64u << 20;  // of a guide that is kept for the next pixel
constexpr float kNoiseLow = 1e-3f, kNoiseHigh = 1;

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

std::string hex_color(Rgb linear) {
  const auto byte = [](float v) { return static_cast<unsigned>(linear_to_srgb(v) * 255 + 0.5f); };
  char text[8];
  std::snprintf(text, sizeof text, "#%02x%02x%02x", byte(linear.r) & 255, byte(linear.g) & 255,
                byte(linear.b) & 255);
  return text;
}

std::array<float, 3> array_of(Vec3 v) { return {v.x, v.y, v.z}; }

proto::PixelState state_of(const ProbedState& probed) {
  proto::PixelState state;
  state.id = probed.at.key;
  state.color = hex_color(state_color(probed.at.key));
  state.known = probed.known;
  if (probed.summary.size_m > 0) state.size_m = probed.summary.size_m;
  state.visits = probed.summary.visits;
  state.gain = probed.gain;
  state.guide_fraction = probed.guide_fraction;
  for (const ProbedDirection& d : probed.directions) {
    state.directions.push_back({array_of(d.cell.wi), d.cell.pdf_w, std::nullopt});
    if (d.rod_end) state.directions.back().screen = {{d.rod_end->x, d.rod_end->y}};
    if (d.cell.size > 0)
      state.cells.push_back({d.cell.corner.x, d.cell.corner.y, d.cell.size, d.cell.pdf_w});
  }
  return state;
}

}  // namespace

struct ViewHandlers::Wanted {
  JobRecord job;
  uint32_t moment = 0;  // 0: the newest
  int frame = 0;
};

struct ViewHandlers::Shown {
  std::string key;  // what it was made of
  std::shared_ptr<const PreparedScene> scene;
  RenderSettings settings;
  std::unique_ptr<Guide> guide;  // may be null
};

void ViewHandlers::add_to(Router& router) {
  router.add("GET", "/v1/jobs/{id}/pixel",
             [this](auto& req, auto& res, auto& id) { pixel(req, res, id); });
  router.add("GET", "/v1/jobs/{id}/view.png",
             [this](auto& req, auto& res, auto& id) { view(req, res, id); });
  router.add("GET", "/v1/jobs/{id}/lobe.png",
             [this](auto& req, auto& res, auto& id) { lobe(req, res, id); });
}

Result<ViewHandlers::Wanted> ViewHandlers::wanted(const Request& req, const std::string& id) const {
  Result<JobRecord> job = stores_.jobs.find(id);
  if (!job.ok()) return job.error();
  const Result<uint32_t> moment = query_number<uint32_t>(req, "moment", 1, UINT32_MAX, 0);
  if (!moment.ok()) return moment.error();
  const Result<int> frame = PictureSource::frame(req, job.value());
  if (!frame.ok()) return frame.error();
  return Wanted{std::move(job).value(), moment.value(), frame.value()};
}

// That of the moment is the last one kept up to then. Its key is known without reading it.
Result<ViewHandlers::FoundTable> ViewHandlers::find_table(const Wanted& wanted) const {
  const JobRecord& job = wanted.job;
  if (wanted.moment == 0 && !job.table_out.empty()) {
    const Result<proto::TableInfo> info = stores_.tables.find(job.table_out);
    if (!info.ok()) return conflict("the job's table cannot be read any more");
    return FoundTable{job.table_out, 0};
  }
  const std::vector<proto::Moment> all = stores_.moments.moments(job.id);
  const auto newest = std::find_if(all.rbegin(), all.rend(), [&](const proto::Moment& m) {
    return m.table && (wanted.moment == 0 || m.number <= wanted.moment);
  });
  if (newest == all.rend()) return FoundTable{};
  // A run that went back makes another moment of the same number, at another time.
  return FoundTable{std::to_string(newest->number) + " " + std::to_string(newest->seconds),
                    newest->number};
}

Result<std::optional<TableFile>> ViewHandlers::read_table(const JobRecord& job,
                                                          const FoundTable& found) {
  std::optional<TableFile> none;
  if (found.key.empty()) return none;
  if (found.moment == 0) {
    Result<TableFile> table = stores_.tables.load(job.table_out);
    if (table.ok()) return std::optional(std::move(table).value());
    spdlog::error("job={} {}", job.id.text(), table.error().text());
    return conflict("the job's table cannot be read any more");
  }
  const Result<Bytes> bytes = stores_.moments.table(job.id, found.moment);
  if (!bytes.ok()) return none;
  Result<TableFile> table = decode_table(bytes.value());
  if (!table.ok()) return none;
  return std::optional(std::move(table).value());
}

// Whatever fails here worked when the job ran: scene or table are not what they were.
Result<std::shared_ptr<const ViewHandlers::Shown>> ViewHandlers::load(const Wanted& wanted,
                                                                      bool needs_guide) {
  const JobRecord& job = wanted.job;
  auto shown = std::make_shared<Shown>();
  Result<std::shared_ptr<const PreparedScene>> scene =
      stores_.scenes.prepare(job.request.get(field::kScene));
  if (!scene.ok()) return conflict("the job's scene cannot be loaded any more");
  shown->scene = std::move(scene).value();
  const Result<FoundTable> found = find_table(wanted);
  if (!found.ok()) return found.error();
  shown->key = job.id.text() + shown->scene->hash.whole().hex() + found.value().key + " " +
               std::to_string(wanted.frame);
  if (last_ && last_->key == shown->key && (last_->guide || !needs_guide)) return last_;
  last_.reset();
  Result<std::optional<TableFile>> table = read_table(job, found.value());
  if (!table.ok()) return table.error();
  if (!table.value() && needs_guide) return conflict("no table of this job is kept");
  shown->settings = settings_of(job.request, shown->scene->scene);
  const Result<std::vector<JobFrame>> frames = frames_of(job.request, shown->scene->scene);
  if (!frames.ok()) return conflict("the job's cameras are not in its scene any more");
  std::optional<double> seconds;  // of what moves
  if (const auto frame = static_cast<size_t>(wanted.frame); frame < frames.value().size()) {
    shown->settings = frame_settings(job.request, shown->settings, frames.value(), wanted.frame);
    seconds = frames.value()[frame].seconds;
  }
  shown->settings.max_table_bytes = stores_.tables.max_bytes();
  if (table.value()) {
    if (!table_fits(table.value()->header, shown->scene->hash))
      return conflict("the scene has changed since the job");
    Result<std::unique_ptr<Guide>> guide =
        load_guide(*shown->scene, shown->settings, std::move(table).value());
    if (!guide.ok())
      return conflict("the job's table cannot be used any more: " + guide.error().message);
    shown->guide = std::move(guide).value();
  }
  if (seconds && shown->scene->scene.moves_surfaces) {
    scene = stores_.scenes.prepare_at(job.request.get(field::kScene), *seconds);
    if (!scene.ok()) return conflict("the job's scene cannot be loaded any more");
    shown->scene = std::move(scene).value();
  }
  if (!shown->guide || shown->guide->stats().bytes <= kMostKeptBytes) last_ = shown;
  return std::shared_ptr<const Shown>(std::move(shown));
}

void ViewHandlers::pixel(const Request& req, Response& res, const std::string& id) {
  const Result<Wanted> wanted = this->wanted(req, id);
  if (!wanted.ok()) return reply_error(res, wanted.error());
  const JobRecord& job = wanted.value().job;
  const Result<int> x = coordinate(req, "x", job.request.given(field::kWidth).value_or(1));
  if (!x.ok()) return reply_error(res, x.error());
  const Result<int> y = coordinate(req, "y", job.request.given(field::kHeight).value_or(1));
  if (!y.ok()) return reply_error(res, y.error());
  const auto which = pictures_.which(req, job, /*best=*/true);
  if (!which.ok()) return reply_error(res, which.error());
  const Turn turn(turns_);
  if (!turn.mine()) return reply_problem(res, kTooManyPictures);
  const auto seen = pictures_.pixel(job, which.value(), x.value(), y.value());
  if (!seen.ok()) return reply_error(res, seen.error());
  proto::PixelInfo info;
  info.x = x.value();
  info.y = y.value();
  const Rgb radiance = seen.value().radiance;
  info.radiance = {radiance.r, radiance.g, radiance.b};
  info.samples = seen.value().samples;
  std::optional<PictureSource::PixelNoise> noise;  // of the newest picture alone
  if (wanted.value().moment == 0)
    noise = pictures_.noise_at(job, wanted.value().frame, info.x, info.y);
  if (noise) {
    info.samples = static_cast<uint64_t>((*noise)[kSamples]);
    if ((*noise)[kDeviation] > 0) info.variance = sqr((*noise)[kDeviation]);
    if (info.variance && info.samples > 0)
      info.standard_error = std::sqrt(*info.variance / static_cast<double>(info.samples));
  }
  const Result<std::shared_ptr<const Shown>> shown = load(wanted.value(), /*needs_guide=*/false);
  if (!shown.ok()) return reply_error(res, shown.error());
  const Result<std::optional<PixelProbe>> probe = probe_pixel(
      *shown.value()->scene, shown.value()->settings, shown.value()->guide.get(), info.x, info.y);
  if (!probe.ok()) return reply_error(res, probe.error());
  if (probe.value()) {
    const SeenSurface& surface = probe.value()->seen;
    info.surface = {array_of(surface.point.p), array_of(surface.point.ns)};
    if (probe.value()->state) info.state = state_of(*probe.value()->state);
  }
  reply_json(res, 200, proto::pixel_to_json(info));
}

void ViewHandlers::view(const Request& req, Response& res, const std::string& id) {
  const std::string name = req.has_param("view") ? req.get_param_value("view") : "";
  if (name == "samples" || name == "noise") return noise_view(req, res, id, name == "samples");
  const std::optional<DebugView> view = parse_debug_view(name);
  if (view && shows_guide(*view)) return guide_view(req, res, id, *view);
  const Result<JobRecord> job = stores_.jobs.find(id);
  reply_error(res, job.ok() ? Error{ErrorCode::kInvalid,
                                    "expected state, beta, gain, samples or noise", "/view"}
                            : job.error());
}

void ViewHandlers::noise_view(const Request& req, Response& res, const std::string& id,
                              bool samples) {
  const Result<JobRecord> job = stores_.jobs.find(id);
  if (!job.ok()) return reply_error(res, job.error());
  const Result<int> frame = PictureSource::frame(req, job.value());
  if (!frame.ok()) return reply_error(res, frame.error());
  const Turn turn(turns_);
  if (!turn.mine()) return reply_problem(res, kTooManyPictures);
  const Result<std::shared_ptr<const Image>> noise = pictures_.noise(job.value(), frame.value());
  if (!noise.ok()) return reply_error(res, noise.error());
  const Image& from = *noise.value();
  float most = 1;
  for (int y = 0; y < from.height(); ++y)
    for (int x = 0; x < from.width(); ++x) most = std::max(most, from.at(x, y, kSamples));
  Image image(from.width(), from.height(), 3);
  for (int y = 0; y < from.height(); ++y)
    for (int x = 0; x < from.width(); ++x) {
      const float count = from.at(x, y, kSamples);
      if (count == 0) continue;  // black
      image.set_rgb(
          x, y,
          viridis(samples ? count / most
                          : log_scale(from.at(x, y, kRelativeError), kNoiseLow, kNoiseHigh)));
    }
  const std::string scale =
      samples
          ? "0 (dark) to " + std::to_string(static_cast<uint64_t>(most)) + " (bright) samples"
          : "relative standard error, 0.001 (dark) to 1 (bright), logarithmic; black: no samples";
  reply_png(res, image, {{"view", samples ? "samples" : "noise"}, {"scale", scale}});
}

void ViewHandlers::guide_view(const Request& req, Response& res, const std::string& id,
                              DebugView view) {
  const Result<Wanted> wanted = this->wanted(req, id);
  if (!wanted.ok()) return reply_error(res, wanted.error());
  const Turn turn(turns_);
  if (!turn.mine()) return reply_problem(res, kTooManyPictures);
  const Result<std::shared_ptr<const Shown>> shown = load(wanted.value(), /*needs_guide=*/true);
  if (!shown.ok()) return reply_error(res, shown.error());
  RenderSettings settings = shown.value()->settings;
  shrink(settings);
  TaskPool pool(1);
  const Result<Image> image =
      render_debug_view(*shown.value()->scene, settings, view, shown.value()->guide.get(),
                        kViewSamples, pool, stop_.get_token());
  if (!image.ok()) return reply_error(res, image.error());
  reply_png(res, image.value(),
            {{"view", req.get_param_value("view")}, {"scale", std::string(scale_of(view))}});
}

void ViewHandlers::lobe(const Request& req, Response& res, const std::string& id) {
  const Result<Wanted> wanted = this->wanted(req, id);
  if (!wanted.ok()) return reply_error(res, wanted.error());
  const JobRequest& request = wanted.value().job.request;
  const Result<int> x = coordinate(req, "x", request.given(field::kWidth).value_or(1));
  if (!x.ok()) return reply_error(res, x.error());
  const Result<int> y = coordinate(req, "y", request.given(field::kHeight).value_or(1));
  if (!y.ok()) return reply_error(res, y.error());
  const Turn turn(turns_);
  if (!turn.mine()) return reply_problem(res, kTooManyPictures);
  const Result<std::shared_ptr<const Shown>> shown = load(wanted.value(), /*needs_guide=*/true);
  if (!shown.ok()) return reply_error(res, shown.error());
  const Result<LobeView> view = render_lobe_view(*shown.value()->scene, shown.value()->settings,
                                                 *shown.value()->guide, x.value(), y.value());
  if (!view.ok()) return reply_error(res, view.error());
  reply_png(res, view.value().image, {{"view", "lobe"}, {"scale", std::string(kLobeScale)}});
}

}  // namespace qray::server
