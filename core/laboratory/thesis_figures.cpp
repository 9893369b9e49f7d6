#include "core/laboratory/thesis_figures.h"

#include <algorithm>
#include <cmath>

#include "core/laboratory/screenshots.h"
#include "core/render/debug_view.h"

namespace qray {
namespace {

constexpr int kLessonSamples = 64;  // a pixel; a quarter of them teach the table
constexpr int kStateSamples = 16;
constexpr int kQuarterSamples = 64;  // a sampled pixel
constexpr int kScreenshotRows = 4;   // figure 2
constexpr int64_t kMaxFigurePixels = int64_t{1} << 26;

using Table = std::optional<TableFile>;

Image halves(const Image& left, const Image& right) {
  Image out = left;
  for (int y = 0; y < out.height(); ++y)
    for (int x = out.width() / 2; x < out.width(); ++x) out.set_rgb(x, y, right.rgb(x, y));
  return out;
}

Image side_by_side(const Image& left, const Image& right) {
  constexpr int kGap = 8;  // pixels, white
  Image out(left.width() + kGap + right.width(), left.height(), 3);
  std::fill(out.data().begin(), out.data().end(), 1.0f);
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < left.width(); ++x) out.set_rgb(x, y, left.rgb(x, y));
    for (int x = 0; x < right.width(); ++x)
      out.set_rgb(left.width() + kGap + x, y, right.rgb(x, y));
  }
  return out;
}

// The second view of figures 11 and 13: from lower down and off to the side, at the same target.
Camera second_view(const Camera& camera) {
  const Vec3 back = camera.position - camera.target;
  const float angle = 0.28f;  // radians about the up axis
  const Vec3 up = normalize(camera.up);
  const Vec3 turned = back * std::cos(angle) + cross(up, back) * std::sin(angle) +
                      up * (dot(up, back) * (1 - std::cos(angle)));
  Camera moved = camera;
  moved.position = camera.target + turned * 0.8f;
  return moved;
}

// One renderer for all pictures of a figure.
class Studio {
 public:
  Studio(const PreparedScene& scene, const ThesisFigure& figure, TaskPool& pool,
         const ThesisWatch& watch, std::stop_token stop)
      : scene_(scene), figure_(figure), pool_(pool), watch_(watch), stop_(std::move(stop)) {}

  Result<Image> draw(const RenderSettings& plain) {
    if (figure_.number <= 4) return quarter(plain);
    if (figure_.number == 8) return states(plain);
    if (figure_.number <= 6) return shoot(plain, std::nullopt);
    return comparison(plain);
  }

 private:
  // Figures 1 to 4: a quarter of the pixels, with direct light sampling, and what comes of them.
  Result<Image> quarter(RenderSettings settings) {
    settings.nee = true;
    if (figure_.number == 2) return screenshots(settings);
    settings.pixels = Pixels::kQuarter;
    settings.samples = figure_.number == 1 ? kQuarterSamples : 1;
    return shoot(settings, std::nullopt, figure_.number == 4 ? figure_.recovery : nullptr);
  }

  // Figure 2: what training sees, side by side.
  Result<Image> screenshots(const RenderSettings& settings) {
    ScreenshotOptions options;
    options.views = kScreenshotRows * kScreenshotRows;
    options.seed = settings.seed;
    const Result<std::vector<TrainingView>> views =
        take_screenshots(scene_, settings, std::nullopt, options, pool_, stop_, SteadyClock(),
                         [&](int done) { watch_.on_view(done, options.views); });
    if (!views) return views.error();
    Image sheet(kScreenshotRows * kScreenshotSide, kScreenshotRows * kScreenshotSide, 3);
    for (int i = 0; i < options.views; ++i)
      for (int y = 0; y < kScreenshotSide; ++y)
        for (int x = 0; x < kScreenshotSide; ++x)
          sheet.set_rgb(i % kScreenshotRows * kScreenshotSide + x,
                        i / kScreenshotRows * kScreenshotSide + y,
                        views.value()[static_cast<size_t>(i)].target.rgb(x, y));
    return sheet;
  }

  Result<Image> states(const RenderSettings& settings) {
    Result<std::unique_ptr<Guide>> grid = make_guide("huang", scene_.guide_setup(settings));
    if (!grid) return grid.error();
    return render_debug_view(scene_, settings, DebugView::kState, grid.value().get(), kStateSamples,
                             pool_, stop_);
  }

  // Figures 10 to 13: without learning on the left, with it on the right.
  Result<Image> comparison(const RenderSettings& plain) {
    const Result<Image> without = shoot(plain, std::nullopt);
    if (!without) return without;
    const Result<Table> table = learn(plain);
    if (!table) return table.error();
    const auto with = [&](const std::string& method) -> Result<Image> {
      RenderSettings guided = plain;
      guided.method = method;
      guided.learning_samples = 0;
      Result<Image> image = shoot(guided, table.value());
      if (!image) return image;
      return halves(without.value(), image.value());
    };
    if (figure_.method != "both") return with(figure_.method);
    Result<Image> published = with("huang-published");
    if (!published) return published;
    Result<Image> corrected = with("huang");
    if (!corrected) return corrected;
    return side_by_side(published.value(), corrected.value());
  }

  // What is learned before a figure, from its camera, with random numbers of its own. Both
  // readings of the method use the same table.
  Result<Table> learn(RenderSettings settings) {
    settings.method = "huang";
    settings.samples = kLessonSamples;
    settings.learning_samples = kLessonSamples / 4;
    settings.seed += 1000;
    Result<std::pair<Image, Table>> learned = render_job(settings, std::nullopt, nullptr);
    if (!learned) return learned.error();
    return std::move(learned).value().second;
  }

  Result<Image> shoot(const RenderSettings& settings, Table table,
                      const Recovery* recovery = nullptr) {
    Result<std::pair<Image, Table>> done = render_job(settings, std::move(table), recovery);
    if (!done) return done.error();
    return std::move(done).value().first;
  }

  Result<std::pair<Image, Table>> render_job(const RenderSettings& settings, Table table,
                                             const Recovery* recovery) {
    Film film(settings.width, settings.height);
    Result<JobResult> job = run_job(scene_, settings, std::move(table), film, pool_, watch_.renders,
                                    stop_, SteadyClock(), recovery);
    if (!job) return job.error();
    return std::pair{recovery ? std::move(*job.value().recovered) : film.develop(),
                     std::move(job.value().table)};
  }

  const PreparedScene& scene_;
  const ThesisFigure& figure_;
  TaskPool& pool_;
  const ThesisWatch& watch_;
  std::stop_token stop_;
};

}  // namespace

Result<Image> draw_thesis_figure(const PreparedScene& scene, const ThesisFigure& figure,
                                 TaskPool& pool, const ThesisWatch& watch, std::stop_token stop) {
  RenderSettings settings;  // the thesis' path tracer: no direct light sampling
  settings.method = "none";
  settings.nee = false;
  settings.width = figure.size ? figure.size->first : scene.scene.width;
  settings.height = figure.size ? figure.size->second : scene.scene.height;
  settings.max_depth = scene.scene.max_depth;
  settings.seed = figure.seed;
  settings.samples = figure.number == 6 ? 64 : figure.number >= 12 ? 80 : 8;
  if (figure.number == 11 || figure.number == 13) settings.camera = second_view(scene.scene.camera);
  if (Status s = check_settings(settings, kMaxFigurePixels); !s) return s.error();
  return Studio(scene, figure, pool, watch, std::move(stop)).draw(settings);
}

}  // namespace qray
