// qray thesis: the figures of "AI and Machine Learning for Real-Time Ray Tracing" again, on our
// own room: recovery of a quarter of the pixels, and guiding, with the published method and the
// corrected one beside it.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "core/cmd/commands.h"
#include "core/cmd/files.h"
#include "core/cmd/progress_line.h"
#include "core/cmd/render_options.h"
#include "core/cmd/report.h"
#include "core/cmd/stop_on_signal.h"
#include "core/job/run_job.h"
#include "core/laboratory/screenshots.h"
#include "core/render/debug_view.h"
#include "core/render/direction_cube.h"

namespace qray::cmd {
namespace {

constexpr int kLessonSamples = 64;  // a pixel; a quarter of them teach the table
constexpr int kStateSamples = 16;
constexpr int kQuarterSamples = 64;  // a sampled pixel
constexpr int kScreenshotRows = 4;   // figure 2

struct Options {
  int figure = 0, threads = default_threads();
  std::string size, out, scene = "thesis-room", method = "both", recover = "auto";
  uint64_t seed = 1;
};

// One renderer for all pictures of a figure.
class Studio {
 public:
  Studio(const PreparedScene& scene, const Options& o, std::stop_token stop)
      : scene_(scene), pool_(o.threads), stop_(std::move(stop)) {}

  Result<Image> shoot(const RenderSettings& settings, std::optional<TableFile> table,
                      const Recovery* recovery = nullptr) {
    Result<std::pair<Image, std::optional<TableFile>>> done =
        run(settings, std::move(table), recovery);
    if (!done) return done.error();
    return std::move(done).value().first;
  }

  // Figure 2: what training sees, side by side.
  Result<Image> screenshots(const RenderSettings& settings) {
    ScreenshotOptions options;
    options.views = kScreenshotRows * kScreenshotRows;
    options.seed = settings.seed;
    ProgressLine line;
    const SteadyClock clock;
    const double start = clock.seconds();
    const Result<std::vector<TrainingView>> views = take_screenshots(
        scene_, settings, std::nullopt, options, pool_, stop_, clock, [&](int done) {
          line.show("screenshots", done / static_cast<double>(options.views),
                    std::to_string(done) + " views", clock.seconds() - start);
        });
    line.finish();
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

  // What is learned before a figure, from its camera, with random numbers of its own. Both
  // readings of the method use the same table.
  Result<std::optional<TableFile>> learn(RenderSettings settings) {
    settings.method = "huang";
    settings.samples = kLessonSamples;
    settings.learning_samples = kLessonSamples / 4;
    settings.seed += 1000;
    Result<std::pair<Image, std::optional<TableFile>>> learned = run(settings, std::nullopt);
    if (!learned) return learned.error();
    return std::move(learned).value().second;
  }

  Result<Image> states(const RenderSettings& settings) {
    Result<std::unique_ptr<Guide>> grid = make_guide("huang", scene_.guide_setup(settings));
    if (!grid) return grid.error();
    return render_debug_view(scene_, settings, DebugView::kState, grid.value().get(), kStateSamples,
                             pool_, stop_);
  }

 private:
  Result<std::pair<Image, std::optional<TableFile>>> run(const RenderSettings& settings,
                                                         std::optional<TableFile> table,
                                                         const Recovery* recovery = nullptr) {
    Film film(settings.width, settings.height);
    ProgressLine line;
    ProgressObserver observer(line);
    Result<JobResult> job = run_job(scene_, settings, std::move(table), film, pool_, observer,
                                    stop_, SteadyClock(), recovery);
    line.finish();
    if (!job) return job.error();
    return std::pair{recovery ? std::move(*job.value().recovered) : film.develop(),
                     std::move(job.value().table)};
  }

  const PreparedScene& scene_;
  TaskPool pool_;
  std::stop_token stop_;
};

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

Result<Image> comparison(Studio& studio, const Options& o, const RenderSettings& plain) {
  const Result<Image> without = studio.shoot(plain, std::nullopt);
  if (!without) return without;
  const Result<std::optional<TableFile>> table = studio.learn(plain);
  if (!table) return table.error();
  const auto with = [&](const char* method) -> Result<Image> {
    RenderSettings guided = plain;
    guided.method = method;
    guided.learning_samples = 0;
    Result<Image> image = studio.shoot(guided, table.value());
    if (!image) return image;
    return halves(without.value(), image.value());
  };
  if (o.method != "both") return with(o.method.c_str());
  Result<Image> published = with("huang-published");
  if (!published) return published;
  Result<Image> corrected = with("huang");
  if (!corrected) return corrected;
  return side_by_side(published.value(), corrected.value());
}

// Figures 1 to 4: a quarter of the pixels, with direct light sampling, and what comes of them.
Result<Image> approach_one(Studio& studio, const Options& o, RenderSettings settings) {
  settings.nee = true;
  if (o.figure == 2) return studio.screenshots(settings);
  settings.pixels = Pixels::kQuarter;
  settings.samples = o.figure == 1 ? kQuarterSamples : 1;
  if (o.figure < 4) return studio.shoot(settings, std::nullopt);
  const Result<std::optional<Recovery>> recovery = find_recovery(o.recover);
  if (!recovery) return recovery.error();
  return studio.shoot(settings, std::nullopt, recovery.value() ? &*recovery.value() : nullptr);
}

Result<Image> draw(const Options& o, const StopOnSignal& stop) {
  std::pair<int, int> size{512, 512};
  if (!o.size.empty()) {
    const Result<std::pair<int, int>> given = parse_size(o.size);
    if (!given) return given.error();
    size = given.value();
  }
  if (o.figure == 9) return draw_direction_cube(size.first, size.second);

  ProgressLine line;
  Result<std::shared_ptr<const PreparedScene>> prepared =
      prepare_named_scene(o.scene, o.threads, line, stop.token());
  if (!prepared) return prepared.error();
  const PreparedScene& scene = *prepared.value();
  RenderSettings settings;  // the thesis' path tracer: no direct light sampling
  settings.method = "none";
  settings.nee = false;
  settings.width = o.size.empty() ? scene.scene.width : size.first;
  settings.height = o.size.empty() ? scene.scene.height : size.second;
  settings.max_depth = scene.scene.max_depth;
  settings.seed = o.seed;
  settings.samples = o.figure == 6 ? 64 : o.figure >= 12 ? 80 : 8;
  if (o.figure == 11 || o.figure == 13) settings.camera = second_view(scene.scene.camera);
  if (Status s = check_settings(settings, int64_t{1} << 26); !s) return s.error();

  Studio studio(scene, o, stop.token());
  if (o.figure <= 4) return approach_one(studio, o, settings);
  if (o.figure == 8) return studio.states(settings);
  if (o.figure <= 6) return studio.shoot(settings, std::nullopt);
  return comparison(studio, o, settings);
}

Status run(const Options& o) {
  if (Status s = check_picture_name(o.out); !s) return s;
  const StopOnSignal stop;
  Result<Image> image = draw(o, stop);
  if (!image) return image.error();
  return write_image(o.out, image.value(),
                     {{"figure", "thesis figure " + std::to_string(o.figure)},
                      {"method", o.figure >= 10 ? o.method : "none"}});
}

}  // namespace

void add_thesis(CLI::App& app, int& exit_code) {
  auto o = std::make_shared<Options>();
  CLI::App* sub = app.add_subcommand("thesis", "draw a figure of the thesis again");
  sub->add_option(
         "--figure", o->figure,
         "1: a quarter of the pixels. 2: views to train with. 3: a quarter, one sample each. "
         "4: recovered from that. 5, 6: 8 and 64 samples a pixel without learning. 8: the states, "
         "a colour each. "
         "9: the 26 standard directions. 10, 11 (second view): 8 samples a pixel, left "
         "half without learning, right half with. 12, 13 (second view): 80 samples")
      ->required()
      ->check(CLI::IsMember({1, 2, 3, 4, 5, 6, 8, 9, 10, 11, 12, 13}));
  sub->add_option("--method", o->method,
                  "figures 10-13: huang-published (as printed, too bright), huang (corrected), or "
                  "both, the published one on the left")
      ->check(CLI::IsMember({"both", "huang-published", "huang"}))
      ->capture_default_str();
  sub->add_option("--recover", o->recover, "figure 4: as qray render --recover")
      ->capture_default_str();
  sub->add_option("--scene", o->scene, "another scene")->capture_default_str();
  sub->add_option("--size", o->size, "WIDTHxHEIGHT of one picture");
  sub->add_option("--seed", o->seed, "of the random numbers");
  sub->add_option("--threads", o->threads, "default: one a processor")->check(CLI::Range(1, 1024));
  sub->add_option("-o,--out", o->out, "figure.png or figure.exr")->required();
  sub->callback([o, &exit_code] {
    if (Status s = run(*o); !s) exit_code = report(s.error());
  });
}

}  // namespace qray::cmd
