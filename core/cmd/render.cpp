// qray render: a picture, rendered here.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <thread>

#include "core/base/file.h"
#include "core/cmd/commands.h"
#include "core/cmd/files.h"
#include "core/cmd/progress_line.h"
#include "core/cmd/render_frames.h"
#include "core/cmd/render_options.h"
#include "core/cmd/render_view.h"
#include "core/cmd/report.h"
#include "core/cmd/stop_on_signal.h"
#include "core/image/animation.h"
#include "core/image/exposure.h"
#include "core/image/image_library.h"
#include "core/job/run_job.h"
#include "core/job/stats_json.h"
#include "core/render/light_mix.h"

namespace qray::cmd {
namespace {

struct RenderCommand {
  RenderOptions render;
  std::vector<int> replay;  // RenderSettings::passes
  int last_pass_tiles = 0, pilot_samples = 0;
  int threads = default_threads();
  int table_mib = static_cast<int>(kDefaultTableBytes >> 20);
  std::string table_in, table_out, json, sampled, passes, view = "beauty", out, exposure;
  std::vector<int> pixel;
  bool quiet = false, strict = false;
  FramesOut frames;  // of a job of many
};

// A picture's name takes one frame, as a job without frames.
bool renders_frames(const RenderCommand& o, const JobRequest& request) {
  if (!asks_for_frames(request)) return false;
  return frame_count(request) != 1 || (!o.out.ends_with(".exr") && !o.out.ends_with(".png"));
}

FramesOut passes_folder(const RenderCommand& o) { return {o.passes, "exr"}; }

ViewOptions view_options(const RenderCommand& o) {
  return {o.view, o.pixel, o.table_in, o.out, o.render.method.has_value(), o.quiet};
}

Status check_frames_outputs(const RenderCommand& o) {
  const auto refuse = [](const char* option) {
    return Error{ErrorCode::kInvalid, "expected no frames beside it", option};
  };
  if (!o.replay.empty()) return refuse("--replay");
  if (!o.sampled.empty()) return refuse("--sampled-out");
  if (o.view != "beauty") return refuse("--view");
  if (o.exposure == "auto")
    return Error{ErrorCode::kInvalid, "expected a number of stops: all frames have the same",
                 "--exposure"};
  if (!o.exposure.empty() && o.frames.format != "png" && !o.frames.plays())
    return Error{ErrorCode::kInvalid, "only a .png is exposed; an .exr keeps the scene's light",
                 "--exposure"};
  for (const std::string& name : {o.json, o.table_out})
    if (!name.empty())
      if (Status s = check_writable(name); !s) return s;
  if (Status s = prepare_output(o.frames); !s || o.passes.empty()) return s;
  return prepare_output(passes_folder(o));
}

// Passes and the file that they go to need each other; a mix can do without.
Status check_passes_out(const RenderCommand& o, const RenderSettings& settings, bool many) {
  if (settings.makes_passes() && settings.mix.empty() && o.passes.empty())
    return Error{ErrorCode::kInvalid, "expected --passes-out beside passes and groups of lights",
                 "--passes-out"};
  if (o.passes.empty()) return {};
  if (!settings.makes_passes())
    return Error{ErrorCode::kInvalid, "expected --passes or --light-groups beside it",
                 "--passes-out"};
  if (o.view != "beauty")
    return Error{ErrorCode::kInvalid, "only the view beauty has passes", "--passes-out"};
  if (many) return {};
  if (!o.passes.ends_with(".exr"))
    return Error{ErrorCode::kInvalid, "expected a name ending in .exr", "--passes-out"};
  return check_writable(o.passes);
}

Status check_outputs(const RenderCommand& o) {
  for (const std::string& name : {o.out, o.sampled})
    if (!name.empty())
      if (Status s = check_picture_name(name); !s) return s;
  for (const std::string& name : {o.json, o.table_out})
    if (!name.empty())
      if (Status s = check_writable(name); !s) return s;
  if (!o.exposure.empty()) {
    if (o.view != "beauty")
      return Error{ErrorCode::kInvalid, "only the view beauty is exposed", "--exposure"};
    if (!o.out.ends_with(".png") && !o.sampled.ends_with(".png"))
      return Error{ErrorCode::kInvalid, "only a .png is exposed; an .exr keeps the scene's light",
                   "--exposure"};
  }
  if (o.view == "beauty" && !o.pixel.empty())
    return Error{ErrorCode::kInvalid, "only the view lobe is of a pixel", "--pixel"};
  if (o.view == "beauty") return {};
  if (!o.table_out.empty() || !o.json.empty())
    return Error{ErrorCode::kInvalid, "only the view beauty learns and has statistics", "--view"};
  return check_view(view_options(o));
}

Status write_beauty(const RenderCommand& o, const std::string& path, Image image,
                    const ImageMetadata& metadata) {
  if (!o.exposure.empty() && path.ends_with(".png")) {
    const float stops = o.exposure == "auto" ? auto_exposure(image) : std::stof(o.exposure);
    if (o.exposure == "auto" && !o.quiet)
      std::fprintf(stderr, "qray: %s: exposure %+.2f\n", path.c_str(), static_cast<double>(stops));
    expose(image, stops);
  }
  return write_image(path, image, metadata);
}

// The table to begin with; its method, where none was asked for.
Result<std::optional<TableFile>> starting_table(const RenderCommand& o, const PreparedScene& scene,
                                                RenderSettings& settings) {
  if (!o.table_out.empty() && settings.method == "none")
    return Error{ErrorCode::kInvalid, "the method none learns no table", "--table-out"};
  Result<std::optional<TableFile>> table = read_fitting_table(o.table_in, scene.hash);
  if (table && table.value() && !o.render.method) settings.method = table.value()->header.method;
  return table;
}

void say_what_it_is(const RenderSettings& settings, const RenderStats& stats) {
  if (stats.recovery != "none")
    std::fprintf(stderr,
                 "qray: recovered (%s): smooth is what a network expects, not what was "
                 "measured\n",
                 stats.recovery.c_str());
  else if (!stats.unbiased)
    std::fprintf(
        stderr, "qray: %s is biased: this picture is not the scene's light\n",
        settings.pixels == Pixels::kByNoise ? "choosing pixels by noise" : settings.method.c_str());
}

// {"job":{...},"frames":[{...},...]}
std::string frames_json(const RenderStats& job, const std::vector<RenderStats>& frames) {
  std::string text = "{\"job\": " + stats_json(job, /*indent=*/false) + ",\n\"frames\": [";
  for (const RenderStats& frame : frames)
    text += (text.back() == '[' ? "\n" : ",\n") + stats_json(frame, /*indent=*/false);
  return text + "]}\n";
}

Status render_frames(const RenderCommand& o, const PreparedScene& scene, const FramesJob& asked,
                     TaskPool& pool, std::stop_token stop) {
  RenderSettings settings = asked.settings;
  const std::vector<JobFrame>& frames = asked.frames;
  Result<std::optional<TableFile>> table = starting_table(o, scene, settings);
  if (!table) return table.error();
  const Result<std::optional<Recovery>> recovery =
      find_recovery(o.render.given.get(field::kRecover));
  if (!recovery) return recovery.error();
  Result<std::unique_ptr<Guide>> guide = load_guide(scene, settings, table.value());
  if (!guide) return guide.error();
  StartingGuide start{std::move(guide).value(), {}};
  if (table.value()) start.table = std::move(table.value()->header);

  ProgressLine line(o.quiet);
  std::vector<Image> pictures(frames.size());  // of an animation
  FrameFiles files(static_cast<int>(frames.size()), line,
                   [&](int frame, Image image, const ImageMetadata& metadata,
                       const std::optional<LayeredPicture>& passes) {
                     if (passes && !o.passes.empty())
                       if (Status s = write_layers(passes_folder(o).picture(frame), passes->layers,
                                                   passes->metadata);
                           !s)
                         return s;
                     if (o.frames.plays()) {
                       pictures[static_cast<size_t>(frame)] = std::move(image);
                       return Status();
                     }
                     return write_beauty(o, o.frames.picture(frame), std::move(image), metadata);
                   });
  const Result<JobResult> job =
      run_frames(scene, {asked.request, settings, frames, asked.scene_at}, std::move(start), files,
                 pool, stop, SteadyClock(), recovery.value() ? &*recovery.value() : nullptr);
  line.finish();
  if (!job) return job.error();
  const JobResult& result = job.value();
  if (o.frames.plays()) {
    const auto picture = [&](int frame) -> Result<Image> {
      Image image = pictures[static_cast<size_t>(frame)];
      if (!o.exposure.empty()) expose(image, std::stof(o.exposure));
      return image;
    };
    const Animation animation{static_cast<int>(frames.size()), o.frames.per_second, picture};
    if (Status s = write_animation(o.frames.path, animation); !s) return s;
  }
  if (!o.table_out.empty()) {
    QRAY_CHECK(result.table.has_value());
    if (Status s = write_file_atomic(o.table_out, encode_table(*result.table)); !s) return s;
  }
  if (!o.json.empty())
    if (Status s = write_text(o.json, frames_json(result.stats, files.stats())); !s) return s;
  say_what_it_is(settings, result.stats);
  return {};
}

Status render_beauty(const RenderCommand& o, const PreparedScene& scene, RenderSettings settings,
                     TaskPool& pool, std::stop_token stop) {
  Result<std::optional<TableFile>> table = starting_table(o, scene, settings);
  if (!table) return table.error();

  const Result<std::optional<Recovery>> recovery =
      find_recovery(o.render.given.get(field::kRecover));
  if (!recovery) return recovery.error();

  Film film(settings.width, settings.height, film_layers(scene.scene, settings));
  ProgressLine line(o.quiet);
  ProgressObserver observer(line);
  Result<JobResult> job =
      run_job(scene, settings, std::move(table).value(), film, pool, observer, stop, SteadyClock(),
              recovery.value() ? &*recovery.value() : nullptr);
  line.finish();
  if (!job) return job.error();
  const JobResult& result = job.value();
  const Status written = result.recovered
                             ? write_beauty(o, o.out, *result.recovered, result.recovered_metadata)
                             : write_beauty(o, o.out, film.develop(), result.metadata);
  if (!written) return written;
  if (result.passes && !o.passes.empty())
    if (Status s = write_layers(o.passes, result.passes->layers, result.passes->metadata); !s)
      return s;
  if (!o.sampled.empty())
    if (Status s = write_beauty(o, o.sampled, film.develop(), result.metadata); !s) return s;
  if (!o.table_out.empty()) {
    QRAY_CHECK(result.table.has_value());
    if (Status s = write_file_atomic(o.table_out, encode_table(*result.table)); !s) return s;
  }
  if (!o.json.empty())
    if (Status s = write_text(o.json, stats_json(result.stats)); !s) return s;
  say_what_it_is(settings, result.stats);
  return {};
}

Status run(const RenderCommand& o) {
  const Result<JobRequest> request = make_request(o.render, kRender);
  if (!request) return request.error();
  const bool many = renders_frames(o, request.value());
  if (Status s = many ? check_frames_outputs(o) : check_outputs(o); !s) return s;
  const StopOnSignal stop;
  ProgressLine line(o.quiet);
  Result<std::shared_ptr<const PreparedScene>> prepared =
      prepare_named_scene(o.render.scene, o.threads, line, stop.token(), o.strict);
  if (!prepared) return prepared.error();
  for (const std::string& warning : prepared.value()->warnings)
    std::fprintf(stderr, "qray: warning: %s\n", warning.c_str());

  Result<RenderSettings> made = make_settings(o.render, prepared.value()->scene);
  if (!made) return made.error();
  RenderSettings settings = std::move(made).value();
  settings.passes = o.replay;
  settings.last_pass_tiles = o.last_pass_tiles;
  settings.pilot_samples = o.pilot_samples;
  settings.max_table_bytes = static_cast<size_t>(o.table_mib) << 20;
  if (Status s = check_settings(settings, kMaxPixels); !s) return s;
  const Result<std::shared_ptr<const PreparedScene>> lit = lit_by_mix(prepared.value(), settings);
  if (!lit) return lit.error();
  const PreparedScene& scene = *lit.value();
  if (const Result<LightSplit> split = light_split(scene.scene, settings); !split)
    return split.error();
  if (Status s = check_passes_out(o, settings, many); !s) return s;
  const Result<std::vector<JobFrame>> frames = frames_of(request.value(), scene.scene);
  if (!frames) return frames.error();
  const auto scene_at = [&](double seconds) -> Result<std::shared_ptr<const PreparedScene>> {
    ProgressLine none(/*quiet=*/true);
    const auto moved =
        prepare_named_scene(o.render.scene, o.threads, none, stop.token(), o.strict, seconds);
    return moved ? lit_by_mix(moved.value(), settings) : moved;
  };
  // It takes a fifth of a second: while the picture renders, but where time bounds it, which then
  // has all processors. What goes wrong is said where it is written.
  std::jthread loads_images;
  if (!(settings.seconds > 0)) loads_images = std::jthread([] { (void)image_library(); });
  TaskPool pool(o.threads);
  if (many)
    return render_frames(o, scene, {request.value(), settings, frames.value(), scene_at}, pool,
                         stop.token());
  std::shared_ptr<const PreparedScene> shown = lit.value();
  if (asks_for_frames(request.value())) {
    const JobFrame& frame = frames.value().front();
    settings.camera = frame.camera;
    if (frame.seconds && scene.scene.moves_surfaces) {
      const auto moved = scene_at(*frame.seconds);
      if (!moved) return moved.error();
      shown = moved.value();
    }
  }
  return o.view == "beauty" ? render_beauty(o, *shown, settings, pool, stop.token())
                            : render_view(view_options(o), *shown, settings, pool, stop.token());
}

}  // namespace

void add_render(CLI::App& app, int& exit_code) {
  auto o = std::make_shared<RenderCommand>();
  CLI::App* sub = app.add_subcommand("render", "render a scene to a picture");
  add_render_options(*sub, o->render, kRender);
  CLI::Option* replay =
      sub->add_option("--replay", o->replay,
                      "samples of each pass of a job, such as 1,1,2,4: repeats it (docs/stats.md)")
          ->delimiter(',');
  sub->add_option("--last-pass-tiles", o->last_pass_tiles,
                  "replay: of the last of --replay's passes, the first so many tiles alone")
      ->check(CLI::Range(1, 1 << 24))
      ->needs(replay);
  sub->add_option("--pilot-samples", o->pilot_samples,
                  "replay: how many samples a pixel the pilot of a job bounded by time had")
      ->check(CLI::Range(1, kMaxSamples))
      ->needs(replay);
  sub->add_option("--threads", o->threads, "default: one a processor")->check(CLI::Range(1, 1024));
  sub->add_option("--table-in", o->table_in,
                  "start from this table; its method, unless --method is given");
  sub->add_option("--table-out", o->table_out, "write what was learned");
  sub->add_option("--table-mib", o->table_mib, "memory of the table: full, it adds no states")
      ->check(CLI::Range(1, 1 << 19))
      ->capture_default_str();
  sub->add_option("--json", o->json, "write statistics (docs/stats.md)");
  sub->add_option("--sampled-out", o->sampled, "with --recover: the picture before it, too");
  sub->add_option("--passes-out", o->passes,
                  "passes.exr with the layers of --passes and --light-groups; of frames a folder "
                  "(docs/passes.md)");
  sub->add_option("--view", o->view,
                  "beauty, or without light: albedo, normal; of a table: state, beta (chance to "
                  "guide), gain, lobe (the directions at a pixel). docs/guiding.md")
      ->check(CLI::IsMember({"beauty", "albedo", "normal", "state", "beta", "gain", "lobe"}));
  sub->add_option("--pixel", o->pixel, "X,Y from the top left: of the view lobe")
      ->delimiter(',')
      ->expected(2);
  add_exposure_option(*sub, o->exposure);
  sub->add_flag("--strict", o->strict,
                "what would be drawn otherwise than the scene says is an error");
  sub->add_flag("-q,--quiet", o->quiet, "no progress");
  sub->add_option("--frame-format", o->frames.format, "of the pictures of frames in a folder")
      ->check(CLI::IsMember({"png", "exr"}))
      ->capture_default_str();
  const CLI::Option* fps =
      sub->add_option("--fps", o->frames.per_second,
                      "frames a second, of a .gif or .mp4; of an --animation its own")
          ->check(CLI::Range(kLeastPerSecond, kMostPerSecond))
          ->capture_default_str();
  sub->add_option("-o,--out", o->out,
                  "picture.exr (linear) or picture.png (sRGB); of frames a folder, or a .gif or "
                  ".mp4 that plays")
      ->required();
  sub->callback([o, fps, &exit_code] {
    o->frames.path = o->out;
    if (const auto own = o->render.given.given(field::kAnimation); own && fps->count() == 0)
      o->frames.per_second = std::clamp(*own, double{kLeastPerSecond}, double{kMostPerSecond});
    if (Status s = run(*o); !s) exit_code = report(s.error());
  });
}

}  // namespace qray::cmd
