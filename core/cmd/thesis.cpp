// qray thesis: a figure of the thesis again (core/laboratory/thesis_figures.h).
#include <CLI/CLI.hpp>
#include <cstdio>

#include "core/cmd/commands.h"
#include "core/cmd/files.h"
#include "core/cmd/progress_line.h"
#include "core/cmd/render_options.h"
#include "core/cmd/report.h"
#include "core/cmd/stop_on_signal.h"
#include "core/laboratory/thesis_figures.h"
#include "core/render/direction_cube.h"

namespace qray::cmd {
namespace {

struct ThesisOptions {
  int figure = 0, threads = default_threads();
  std::string size, out, scene = "thesis-room", method = "both", recover = "auto";
  uint64_t seed = 1;
};

Result<Image> draw(const ThesisOptions& o, const StopOnSignal& stop) {
  ThesisFigure figure{o.figure, o.method, std::nullopt, o.seed};
  if (!o.size.empty()) {
    const Result<std::pair<int, int>> given = parse_size(o.size);
    if (!given) return given.error();
    figure.size = given.value();
  }
  if (o.figure == 9) {
    const auto [width, height] = figure.size.value_or(std::pair{512, 512});
    return draw_direction_cube(width, height);
  }
  ProgressLine line;
  Result<std::shared_ptr<const PreparedScene>> scene =
      prepare_named_scene(o.scene, o.threads, line, stop.token());
  if (!scene) return scene.error();
  Result<std::optional<Recovery>> recovery = std::optional<Recovery>();
  if (o.figure == 4) recovery = find_recovery(o.recover);
  if (!recovery) return recovery.error();
  if (recovery.value()) figure.recovery = &*recovery.value();

  ProgressObserver renders(line);
  const SteadyClock clock;
  const double start = clock.seconds();
  const ThesisWatch watch{renders, [&](int done, int all) {
                            line.show("screenshots", done / static_cast<double>(all),
                                      std::to_string(done) + " views", clock.seconds() - start);
                          }};
  TaskPool pool(o.threads);
  Result<Image> image = draw_thesis_figure(*scene.value(), figure, pool, watch, stop.token());
  line.finish();
  return image;
}

Status run(const ThesisOptions& o) {
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
  auto o = std::make_shared<ThesisOptions>();
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
