// qray live: a flight through a scene at a fixed time a frame, measured against long renders: the
// figures of docs/live.md.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <bit>
#include <cstdio>

#include "core/base/file.h"
#include "core/cmd/commands.h"
#include "core/cmd/files.h"
#include "core/cmd/render_options.h"
#include "core/cmd/report.h"
#include "core/cmd/stop_on_signal.h"
#include "core/image/metrics.h"
#include "core/laboratory/chart/reference.h"
#include "core/laboratory/live_flight.h"
#include "core/live/lights.h"
#include "core/math/hash.h"
#include "proto/json_text.h"

namespace qray::cmd {
namespace {

constexpr double kAfterEvent = 0.5;  // seconds: what was seen before must be gone
constexpr double kFlownSeconds = 1;  // before the camera rests
constexpr int kRestMoments = 20;

struct LiveOptions {
  std::string scene, flight, size, method = "adaptive", recover = "default", table_in, out, cache;
  std::vector<std::string> variants;
  double budget_ms = 110, reference_seconds = 20, rest = 0;
  int references = 8, threads = default_threads();
  bool quiet = false;
};

// Which camera it is, for a file's name.
std::string camera_hash(const Camera& c) {
  uint64_t hash = 0;
  for (const float v : {c.position.x, c.position.y, c.position.z, c.target.x, c.target.y,
                        c.target.z, c.up.x, c.up.y, c.up.z, c.vertical_fov_deg})
    hash = hash_combine(hash, std::bit_cast<uint32_t>(v));
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

// The reference at a time of the flight; made, and kept, if there is none.
Result<Image> reference_at(const LiveOptions& o, const Flight& flight, double seconds,
                           const PreparedScene& scene, RenderSettings settings, TaskPool& pool,
                           std::stop_token stop) {
  settings.camera = flight.at(seconds);
  settings.seconds = o.reference_seconds;
  settings.samples = 0;
  settings.seed = 1000;
  const std::filesystem::path path = reference_path(
      o.cache, scene.scene.name + "-" + camera_hash(*settings.camera), scene, settings);
  Result<std::optional<Reference>> found = find_reference(path, o.reference_seconds);
  if (!found) return found.error();
  if (found.value()) return std::move(found.value()->picture);
  if (!o.quiet) std::fprintf(stderr, "qray: the reference at %.2f s\n", seconds);
  RenderObserver nobody;
  Result<Reference> made = make_reference(path, scene, settings, pool, nobody, stop, SteadyClock());
  if (!made) return made.error();
  return std::move(made).value().picture;
}

double part_of(std::vector<double> values, double part) {
  if (values.empty()) return 0;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

void print_table(const std::vector<FlightMeasures>& all) {
  std::printf("%-16s %6s %7s %7s %9s %9s %9s %7s | ms: %8s %8s %8s %8s %8s\n", "", "fps", "p95 ms",
              "side", "relMSE", "trimmed", "flicker", "paths", "features", "reproj", "samples",
              "learning", "recovery");
  for (const FlightMeasures& m : all) {
    const double frames = static_cast<double>(m.frames), ms = 1000 / frames;
    std::printf(
        "%-16s %6.2f %7.1f %7.2f %9.5f %9.5f %9.6f %6.0fk | %12.1f %8.1f %8.1f %8.1f %8.1f\n",
        m.name.c_str(), frames / m.seconds, 1000 * part_of(m.frame_seconds, 0.95), m.side / frames,
        m.mean(m.relmse), m.mean(m.trimmed), m.flicker, m.paths / frames / 1000,
        m.times.features * ms, m.times.reprojection * ms, m.times.samples * ms,
        m.times.learning * ms, m.times.recovery * ms);
  }
}

void print_events(const Flight& flight, const std::vector<FlightMeasures>& all) {
  for (const double event : flight.events()) {
    std::printf("%.1f s after the picture changed at %.2f s, relMSE (trimmed):", kAfterEvent,
                event);
    for (const FlightMeasures& m : all)
      if (const auto found = m.relmse.find(event + kAfterEvent); found != m.relmse.end())
        std::printf("  %s %.5f (%.5f)", m.name.c_str(), found->second,
                    m.trimmed.at(event + kAfterEvent));
    std::printf("\n");
  }
}

Status write_json(const LiveOptions& o, const std::vector<FlightMeasures>& all) {
  std::string text;
  for (const FlightMeasures& m : all) {
    const double frames = static_cast<double>(m.frames);
    const std::vector<proto::JsonField> fields = {
        {"variant", m.name},
        {"frames", static_cast<uint64_t>(m.frames)},
        {"frames_per_second", frames / m.seconds},
        {"frame_ms_p95", 1000 * part_of(m.frame_seconds, 0.95)},
        {"side", m.side / frames},
        {"relmse", m.mean(m.relmse)},
        {"relmse_trimmed", m.mean(m.trimmed)},
        {"flicker", m.flicker},
        {"paths_per_frame", m.paths / frames},
        {"rays_per_second", m.rays / m.seconds},
        {"features_ms", 1000 * m.times.features / frames},
        {"reprojection_ms", 1000 * m.times.reprojection / frames},
        {"samples_ms", 1000 * m.times.samples / frames},
        {"learning_ms", 1000 * m.times.learning / frames},
        {"recovery_ms", 1000 * m.times.recovery / frames}};
    text += proto::json_object(fields, false) + "\n";
  }
  return write_text(std::filesystem::path(o.out) / "flight.jsonl", text);
}

struct Moment {
  double seconds;  // since the camera came to rest
  LiveFrame frame;
};

// Flies the last second and rests where it ends: the frames that are shown at kRestMoments moments.
Result<std::vector<Moment>> moments_at_rest(const LiveOptions& o, const FlightRun& run,
                                            TaskPool& pool, std::stop_token stop) {
  Result<std::unique_ptr<Guide>> guide = load_guide(*run.scene, run.settings.render, run.table);
  if (!guide) return guide.error();
  const SteadyClock clock;
  LiveView view(run.scene, run.settings, std::move(guide).value(), run.network, pool, clock);
  const double end = run.flight.seconds(), start = clock.seconds();
  std::vector<Moment> moments;
  for (double now = 0; now < kFlownSeconds + o.rest; now = clock.seconds() - start) {
    view.set_camera(run.flight.at(std::min(end, end - kFlownSeconds + now)));
    std::optional<LiveFrame> frame = view.next_frame(stop);
    if (!frame) return Error{ErrorCode::kCanceled, "canceled", ""};
    const double rested = clock.seconds() - start - kFlownSeconds;
    if (frame->stage != LiveStage::kMoving &&
        rested >= o.rest * static_cast<double>(moments.size() + 1) / kRestMoments)
      moments.push_back({rested, std::move(*frame)});
  }
  return moments;
}

// A camera at rest where the flight ends: its pictures' errors as time passes, and at the end that
// of a job of the same samples.
Status rest(const LiveOptions& o, const FlightRun& run, const Image& reference, TaskPool& pool,
            std::stop_token stop) {
  const Result<std::vector<Moment>> moments = moments_at_rest(o, run, pool, stop);
  if (!moments) return moments.error();
  if (moments.value().empty())
    return Error{ErrorCode::kInvalid, "expected more seconds: no frame was shown", "--rest"};
  const auto print = [](const ImageDifference& d) {
    std::printf("%9.6f %9.6f %7.4f %7.3f\n", d.relmse, d.relmse_trimmed, d.flip, d.mean_ratio);
  };
  std::printf("at rest, s  stage     side  samples    relMSE   trimmed    FLIP    mean\n");
  for (const Moment& m : moments.value()) {
    const Result<ImageDifference> error = image_difference(m.frame.picture, reference);
    if (!error) return error.error();
    std::printf("%10.2f  %-8s  %4.2f  %7.2f ", m.seconds,
                std::string(live_stage_name(m.frame.stage)).c_str(), m.frame.scale,
                m.frame.samples_per_pixel);
    print(error.value());
    const auto name = "rest-" + std::to_string(static_cast<int>(m.seconds * 1000)) + ".png";
    if (Status s = write_image(std::filesystem::path(o.out) / name, m.frame.picture); !s) return s;
  }
  RenderSettings settings = run.settings.render;
  settings.camera = run.flight.at(run.flight.seconds());
  settings.samples = std::max(1, static_cast<int>(moments.value().back().frame.samples_per_pixel));
  Film film(settings.width, settings.height);
  RenderObserver nobody;
  const Result<JobResult> job =
      run_job(*run.scene, settings, run.table, film, pool, nobody, stop, SteadyClock());
  if (!job) return job.error();
  const Result<ImageDifference> error = image_difference(film.develop(), reference);
  if (!error) return error.error();
  std::printf("a job of as many samples       %7d ", settings.samples);
  print(error.value());
  return {};
}

Status run(const LiveOptions& o) {
  std::error_code ec;
  std::filesystem::create_directories(o.out, ec);
  if (ec) return Error{ErrorCode::kIo, "cannot make the folder: " + ec.message(), o.out};
  const StopOnSignal stop;
  ProgressLine line(o.quiet);
  Result<std::shared_ptr<const PreparedScene>> scene =
      prepare_named_scene(o.scene, o.threads, line, stop.token());
  if (!scene) return scene.error();
  RenderOptions render;
  render.method = o.method;
  render.size = o.size;
  Result<RenderSettings> settings = make_settings(render, scene.value()->scene);
  if (!settings) return settings.error();
  settings.value().pixels = Pixels::kQuarter;  // whose sides must be even, as a frame's
  if (Status s = check_settings(settings.value(), SceneLimits().max_pixels); !s) return s;
  settings.value().pixels = Pixels::kAll;
  Result<Flight> flight = load_flight(o.flight, scene.value()->scene.camera);
  if (!flight) return flight.error();
  for (const FlightKey& key : flight.value().keys)
    if (!key.lights.empty() && key.lights.size() != light_names(scene.value()->scene).size())
      return Error{ErrorCode::kInvalid, "expected as many factors as the scene has lights",
                   o.flight};
  Result<std::optional<Recovery>> recovery = find_recovery(o.recover);
  if (!recovery) return recovery.error();
  if (recovery.value() && recovery.value()->peer)
    return Error{ErrorCode::kInvalid, "expected a network: oidn makes no live frames", "--recover"};
  Result<std::optional<TableFile>> table = read_fitting_table(o.table_in, scene.value()->hash);
  if (!table) return table.error();

  FlightRun flown{scene.value(),
                  std::move(flight).value(),
                  {settings.value(), o.budget_ms / 1000, 0},
                  recovery.value() ? recovery.value()->network : Network{},
                  std::move(table).value(),
                  {},
                  {},
                  {}};
  for (const LiveVariant& variant : live_variants())
    if (std::find(o.variants.begin(), o.variants.end(), variant.name) != o.variants.end())
      flown.variants.push_back(variant);
  TaskPool pool(o.threads);
  std::vector<double> times;
  for (int i = 1; i <= o.references; ++i)
    times.push_back(flown.flight.seconds() * i / o.references);
  for (const double event : flown.flight.events()) times.push_back(event + kAfterEvent);
  for (const double seconds : times) {
    std::shared_ptr<const PreparedScene> lit = scene.value();
    if (const std::vector<float> lights = flown.flight.lights_at(seconds); !lights.empty()) {
      Result<std::shared_ptr<const PreparedScene>> changed = with_lights(lit, lights);
      if (!changed) return changed.error();
      lit = changed.value();
    }
    Result<Image> reference =
        reference_at(o, flown.flight, seconds, *lit, settings.value(), pool, stop.token());
    if (!reference) return reference.error();
    const auto number = std::to_string(static_cast<int>(seconds * 1000));
    if (Status s = write_image(std::filesystem::path(o.out) / (number + "-reference.png"),
                               reference.value());
        !s)
      return s;
    flown.references[seconds] = std::move(reference).value();
  }
  flown.on_picture = [&](const std::string& variant, double seconds, const Image& picture) {
    const auto number = std::to_string(static_cast<int>(seconds * 1000));
    (void)write_image(std::filesystem::path(o.out) / (number + "-" + variant + ".png"), picture);
  };
  if (!flown.variants.empty()) {
    const Result<std::vector<FlightMeasures>> measured = fly(flown, pool, stop.token());
    if (!measured) return measured.error();
    print_table(measured.value());
    print_events(flown.flight, measured.value());
    if (Status s = write_json(o, measured.value()); !s) return s;
  }
  if (o.rest > 0)
    return rest(o, flown, flown.references[flown.flight.seconds()], pool, stop.token());
  return {};
}

}  // namespace

void add_live(CLI::App& app, int& exit_code) {
  CLI::App* live = app.add_subcommand(
      "live", "flies a camera through a scene at a fixed time a frame, and measures the pictures");
  auto o = std::make_shared<LiveOptions>();
  for (const LiveVariant& variant : live_variants()) o->variants.push_back(variant.name);
  live->add_option("scene", o->scene, "as for qray render")->required();
  live->add_option("--flight", o->flight, "the camera's way, a file (docs/live.md)")->required();
  live->add_option("-o,--out", o->out, "a folder, for pictures and flight.jsonl")->required();
  live->add_option("--cache", o->cache, "a folder where references are kept")->required();
  live->add_option("--size", o->size, "WIDTHxHEIGHT in pixels, even; default: the scene's");
  live->add_option("--method", o->method, "as for qray render")->capture_default_str();
  live->add_option("--recover", o->recover, "a network, as for qray render")->capture_default_str();
  live->add_option("--table-in", o->table_in, "what all views start from");
  live->add_option("--budget-ms", o->budget_ms, "for each frame")
      ->check(CLI::Range(5.0, 10000.0))
      ->capture_default_str();
  live->add_option("--variants", o->variants, "what flies, with what switched off")
      ->delimiter(',')
      ->check(CLI::IsMember(o->variants))
      ->capture_default_str();
  live->add_option("--references", o->references, "long renders, evenly along the flight")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  live->add_option("--reference-seconds", o->reference_seconds, "for each")
      ->check(CLI::Range(0.1, 86400.0))
      ->capture_default_str();
  live->add_option(
          "--rest", o->rest,
          "seconds at the flight's end: the picture as they pass, and a job of as many samples")
      ->check(CLI::Range(0.0, 3600.0));
  live->add_option("--threads", o->threads, "default: one a processor")->check(CLI::Range(1, 1024));
  live->add_flag("-q,--quiet", o->quiet, "no progress");
  live->callback([o, &exit_code] {
    const Status status = run(*o);
    exit_code = status.ok() ? kExitOk : report(status.error());
  });
}

}  // namespace qray::cmd
