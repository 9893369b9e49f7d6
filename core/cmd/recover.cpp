// qray recover: networks that clean pictures: train, compare, info.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <numeric>
#include <span>

#include "core/base/file.h"
#include "core/base/sha256.h"
#include "core/cmd/commands.h"
#include "core/cmd/files.h"
#include "core/cmd/progress_line.h"
#include "core/cmd/render_options.h"
#include "core/cmd/report.h"
#include "core/cmd/stop_on_signal.h"
#include "core/laboratory/generated_scene.h"
#include "core/laboratory/screenshots.h"
#include "core/laboratory/views_file.h"
#include "core/recover/included_networks.h"
#include "core/recover/joint_bilateral.h"
#include "core/recover/ladder.h"
#include "core/recover/recover.h"
#include "core/scene/scene_hash.h"
#include "core/scene/validate.h"

namespace qray::cmd {
namespace {

constexpr int kViewsOverGenerated = 4;  // views of a real scene over those of a generated one

struct RecoverOptions {
  std::vector<std::string> scenes, weights, more_views;
  std::string scene, table_in, method = "none", out, first, keep, rung;
  int threads = default_threads(), held_out = 8, generated = 0;
  ScreenshotOptions views;
  TrainOptions train;
  bool quiet = false;
};

// Views of a scene, with what says which it was.
struct Album {
  std::vector<TrainingView> views;
  SceneHash hash;
  std::string name;
};

// The included scene or file of that name or, where there is none, the generated one of the seed.
Result<std::shared_ptr<const PreparedScene>> scene_of(const std::string& name, uint64_t seed,
                                                      int threads, ProgressLine& line,
                                                      std::stop_token stop) {
  if (!name.empty()) return prepare_named_scene(name, threads, line, std::move(stop));
  Scene scene = generated_scene(seed);
  if (Result<ValidateReport> valid = validate(scene); !valid) return valid.error();
  const Result<SceneHash> hash = hash_scene(scene);
  if (!hash) return hash.error();
  Result<std::shared_ptr<PreparedScene>> prepared =
      prepare_scene(std::move(scene), hash.value(), threads);
  if (!prepared) return prepared.error();
  return std::shared_ptr<const PreparedScene>(std::move(prepared).value());
}

// Where views of the scene by these options are kept; empty: nowhere.
std::filesystem::path kept_views_path(const RecoverOptions& o, const SceneHash& hash) {
  if (o.keep.empty()) return {};
  ByteWriter bytes;
  for (const Digest* d : {&hash.geometry, &hash.materials, &hash.lights}) bytes.bytes(d->bytes);
  for (const int n : {o.views.views, o.views.inputs, o.views.least_samples, o.views.most_samples,
                      o.views.target_samples, static_cast<int>(o.views.guided_targets)})
    bytes.u32(static_cast<uint32_t>(n));
  bytes.u64(o.views.seed);
  bytes.string(o.method);
  bytes.string(o.table_in);
  return std::filesystem::path(o.keep) / (sha256(bytes.data()).hex().substr(0, 32) + ".views");
}

Result<Album> take_album(const std::string& name, const RecoverOptions& o, TaskPool& pool,
                         std::stop_token stop) {
  ProgressLine line(o.quiet);
  Result<std::shared_ptr<const PreparedScene>> scene =
      scene_of(name, o.views.seed, o.threads, line, stop);
  if (!scene) return scene.error();
  RenderOptions render;
  render.scene = name;
  render.method = o.method;
  Result<RenderSettings> settings = make_settings(render, scene.value()->scene);
  if (!settings) return settings.error();
  const Result<std::optional<TableFile>> table =
      read_fitting_table(o.table_in, scene.value()->hash);
  if (!table) return table.error();
  if (table.value()) settings.value().method = table.value()->header.method;
  const std::filesystem::path kept = kept_views_path(o, scene.value()->hash);
  if (!kept.empty() && std::filesystem::exists(kept)) {
    Result<std::vector<TrainingView>> views = read_views(kept);
    if (!views) return views.error();
    return Album{std::move(views).value(), scene.value()->hash, scene.value()->scene.name};
  }
  const SteadyClock clock;
  const double start = clock.seconds();
  Result<std::vector<TrainingView>> views = take_screenshots(
      *scene.value(), settings.value(), table.value(), o.views, pool, stop, clock, [&](int done) {
        line.show(scene.value()->scene.name,
                  done / static_cast<double>(o.views.views * o.views.inputs),
                  std::to_string(done) + " views", clock.seconds() - start);
      });
  line.finish();
  if (!views) return views.error();
  if (!kept.empty())
    if (Status s = write_views(kept, views.value()); !s) return s.error();
  return Album{std::move(views).value(), scene.value()->hash, scene.value()->scene.name};
}

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

// Views of all scenes: those to be learned from, then `held_out` kept apart, as many of each scene.
Result<std::vector<TrainingView>> all_views(const RecoverOptions& o, TaskPool& pool,
                                            std::stop_token stop, size_t& held_out, Album& last) {
  std::vector<TrainingView> taught, kept;
  for (const std::string& name : o.scenes) {
    Result<Album> album = take_album(name, o, pool, stop);
    if (!album) return album.error();
    auto& views = album.value().views;
    const auto apart = views.end() - o.held_out * o.views.inputs;
    std::move(views.begin(), apart, std::back_inserter(taught));
    std::move(apart, views.end(), std::back_inserter(kept));
    last = std::move(album).value();
  }
  RecoverOptions made_up = o;
  made_up.views.views = std::max(1, o.views.views / kViewsOverGenerated);
  for (int i = 0; i < o.generated; ++i) {
    made_up.views.seed = o.views.seed + static_cast<uint64_t>(i);
    Result<Album> album = take_album("", made_up, pool, stop);
    if (!album) return album.error();
    std::ranges::move(album.value().views, std::back_inserter(taught));
  }
  for (const std::string& path : o.more_views) {
    Result<std::vector<TrainingView>> views = read_views(path);
    if (!views) return views.error();
    std::ranges::move(views.value(), std::back_inserter(taught));
  }
  held_out = kept.size();
  std::move(kept.begin(), kept.end(), std::back_inserter(taught));
  return taught;
}

void print_rungs(const Ladder& ladder) {
  std::printf("%-12s %10s %8s %9s\n", "model", "held out", "steps", "cpu s");
  for (size_t i = 0; i < ladder.rungs.size(); ++i) {
    const Rung& r = ladder.rungs[i];
    std::printf("%-12s %10.5f %8d %9.1f%s\n", r.name.c_str(), r.mean_held_out(), r.steps,
                r.cpu_seconds, i == ladder.chosen ? "  <- the cheapest that is as good" : "");
  }
}

Status write_weights(const std::string& path, WeightsFile& file) {
  file.id = weights_id(file);
  return write_file_atomic(path, encode_weights(file));
}

void take(WeightsFile& file, const Rung& rung) {
  file.network = rung.network;
  file.steps = static_cast<uint32_t>(rung.steps);
  file.held_out.clear();
  for (double e : rung.held_out) file.held_out.push_back(static_cast<float>(std::max(e, 0.0)));
}

// It may be hours of work: the file is written at each look at the views kept apart, so that what
// stops it loses little.
Status train_into(WeightsFile& file, const RecoverOptions& o, std::span<const TrainingView> views,
                  size_t held_out, TaskPool& pool, const StopOnSignal& stop) {
  Rung first{"included", {}};
  if (o.first.empty()) {
    first.network = included_network("default").value();
  } else {
    Result<WeightsFile> read = read_weights(o.first);
    if (!read) return read.error();
    first = {o.first, std::move(read).value().network};
  }
  ProgressLine line(o.quiet);
  const SteadyClock clock;
  const double start = clock.seconds();
  Status written;
  Result<Ladder> climbed = climb(
      std::move(first), views, held_out, o.train, pool, stop.token(), [&](const TrainProgress& p) {
        if (!p.values.empty()) {
          file.network.values.assign(p.values.begin(), p.values.end());
          file.steps = static_cast<uint32_t>(p.step);
          written = write_weights(o.out, file);
        }
        line.show("training", p.step / static_cast<double>(o.train.steps),
                  std::to_string(p.step) + " steps, loss " + std::to_string(p.loss) +
                      ", held out " + std::to_string(p.held_out),
                  clock.seconds() - start);
      });
  line.finish();
  if (!climbed) return climbed.error();
  if (!written.ok()) return written;
  Ladder& ladder = climbed.value();
  for (size_t i = 0; i < ladder.rungs.size(); ++i)
    if (ladder.rungs[i].name == o.rung) ladder.chosen = i;
  print_rungs(ladder);
  take(file, ladder.rungs[ladder.chosen]);
  return write_weights(o.out, file);
}

Status train_weights(const RecoverOptions& o) {
  if (Status s = check_writable(o.out); !s) return s;
  if (o.held_out >= o.views.views)
    return Error{ErrorCode::kInvalid, "expected fewer views kept apart than views", "--held-out"};
  const StopOnSignal stop;
  TaskPool pool(o.threads);
  size_t held_out = 0;
  Album last;
  Result<std::vector<TrainingView>> views = all_views(o, pool, stop.token(), held_out, last);
  if (!views) return views.error();

  WeightsFile file;
  file.program = QRAY_VERSION;
  const size_t scenes = o.scenes.size() + static_cast<size_t>(o.generated);
  file.scene = scenes == 1 ? last.name : std::to_string(scenes) + " scenes";
  if (scenes == 1) {
    file.geometry = last.hash.geometry;
    file.materials = last.hash.materials;
    file.lights = last.hash.lights;
  }
  return train_into(file, o, views.value(), held_out, pool, stop);
}

struct Compared {
  std::string name;
  std::vector<double> errors;  // of each view
};

// How many times less error than `other`'s, in the middle view.
double median_ratio(const Compared& row, const Compared& other) {
  constexpr double kLeast = 1e-6;  // an error may be lost in the target's own
  std::vector<double> ratios;
  for (size_t i = 0; i < row.errors.size(); ++i)
    ratios.push_back(std::max(other.errors[i], kLeast) / std::max(row.errors[i], kLeast));
  std::nth_element(ratios.begin(), ratios.begin() + std::ssize(ratios) / 2, ratios.end());
  return ratios[ratios.size() / 2];
}

void print_compared(const std::vector<Compared>& rows, const Compared& bilinear,
                    const Compared& bilateral) {
  std::printf("%-34s %12s %26s\n%-34s %12s %12s %13s\n", "", "mean", "median view, times below", "",
              "relMSE", "bilinear", "bilateral");
  for (const Compared& row : rows)
    std::printf("%-34s %12.5f %12.2f %13.2f\n", row.name.c_str(), mean_of(row.errors),
                median_ratio(row, bilinear), median_ratio(row, bilateral));
}

Status compare(const RecoverOptions& o) {
  std::vector<std::pair<std::string, Network>> networks;
  for (const char* name : {"bilinear", "untrained", "default"})
    networks.emplace_back(name, included_network(name).value());
  for (const std::string& name : o.weights) {
    Result<WeightsFile> file = read_weights(name);
    if (!file) return file.error();
    networks.emplace_back(name, std::move(file).value().network);
  }
  const StopOnSignal stop;
  TaskPool pool(o.threads);
  // The filter is fitted to other views than those compared on.
  RecoverOptions fitting = o;
  fitting.views.seed += 1000;
  Result<Album> others = take_album(o.scene, fitting, pool, stop.token());
  if (!others) return others.error();
  Result<Album> album = take_album(o.scene, o, pool, stop.token());
  if (!album) return album.error();
  const JointBilateral filter = fitted_joint_bilateral(others.value().views, pool);

  std::vector<Compared> rows;
  const auto measure = [&](const std::string& name, auto&& recovered) {
    rows.push_back({name, {}});
    for (const TrainingView& view : album.value().views)
      rows.back().errors.push_back(picture_error(recovered(view), view));
  };
  for (const auto& [name, net] : networks)
    measure(name,
            [&](const TrainingView& v) { return recover_quarter(net, v.input, pool).picture; });
  measure("bilateral", [&](const TrainingView& v) {
    return joint_bilateral(filter, v.input.features, v.input.colour, pool);
  });
  print_compared(rows, rows.front(), rows.back());
  return {};
}

Status info(const RecoverOptions& o) {
  Result<WeightsFile> read = read_weights(o.weights[0]);
  if (!read) return read.error();
  const WeightsFile& w = read.value();
  const std::vector<double> errors(w.held_out.begin(), w.held_out.end());
  std::printf(
      "id         %s\nscene      %s\nprogram    %s\nvalues     %zu\n"
      "steps      %u\nheld out   %.5f (%zu views)\n",
      w.id.c_str(), w.scene.c_str(), w.program.c_str(), w.network.values.size(), w.steps,
      errors.empty() ? 0.0 : mean_of(errors), errors.size());
  return {};
}

void add_view_options(CLI::App& app, RecoverOptions& o) {
  app.add_option("--method", o.method, "that renders the views")->capture_default_str();
  app.add_option("--table-in", o.table_in, "its table");
  app.add_option("--views", o.views.views, "pictures of 128 x 128 from random places")
      ->check(CLI::Range(2, 4096))
      ->capture_default_str();
  app.add_option("--least-spp", o.views.least_samples, "of a view's input")
      ->check(CLI::Range(1, 65536))
      ->capture_default_str();
  app.add_option("--most-spp", o.views.most_samples, "twice as many in each next view, up to this")
      ->check(CLI::Range(1, 65536))
      ->capture_default_str();
  app.add_option("--inputs", o.views.inputs, "noisy pictures of each view, in other random numbers")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_flag("--guided-targets", o.views.guided_targets, "made by 'adaptive'");
  app.add_option("--target-spp", o.views.target_samples, "of what it is to become")
      ->check(CLI::Range(1, 65536))
      ->capture_default_str();
  app.add_option("--keep-views", o.keep, "a folder for views that were taken, for other trainings")
      ->check(CLI::ExistingDirectory);
  app.add_option("--seed", o.views.seed, "of places, pictures and training");
  app.add_option("--threads", o.threads, "default: one a processor")->check(CLI::Range(1, 1024));
  app.add_flag("-q,--quiet", o.quiet, "no progress");
}

}  // namespace

void add_recover(CLI::App& app, int& exit_code) {
  CLI::App* group = app.add_subcommand(
      "recover", "networks that clean pictures, and make one of a quarter of its pixels");
  group->require_subcommand(1);
  const auto run = [&exit_code](CLI::App* sub, Status (*command)(const RecoverOptions&),
                                std::shared_ptr<RecoverOptions> o) {
    sub->callback([o, command, &exit_code] {
      if (Status s = command(*o); !s) exit_code = report(s.error());
    });
  };

  auto train_options = std::make_shared<RecoverOptions>();
  CLI::App* train_command = group->add_subcommand(
      "train",
      "take pictures of scenes, train a network, keep it if it is better than the included one");
  train_command->add_option("scenes", train_options->scenes, "included names, folders or files")
      ->required();
  add_view_options(*train_command, *train_options);
  train_command->add_option("--held-out", train_options->held_out, "views of each scene kept apart")
      ->check(CLI::Range(1, 4095))
      ->capture_default_str();
  train_command
      ->add_option("--steps", train_options->train.steps, "of training; 0: views are taken alone")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  train_command->add_option("--first", train_options->first,
                            "a file whose network goes on being trained; else the included one");
  train_command
      ->add_option("--keep", train_options->rung,
                   "what was trained, or the mean of it and what was there: whatever is better")
      ->check(CLI::IsMember({"trained", "mean"}));
  train_command
      ->add_option("--generated", train_options->generated,
                   "made-up rooms to learn from, too; a quarter as many views of each")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  train_command
      ->add_option("--more-views", train_options->more_views,
                   "files that --keep-views wrote, of any scenes, to learn from too")
      ->check(CLI::ExistingFile);
  train_command->add_option("-o,--out", train_options->out, "weights.qrw")->required();
  run(train_command, train_weights, train_options);

  auto compare_options = std::make_shared<RecoverOptions>();
  CLI::App* compare_command =
      group->add_subcommand("compare", "errors of models and of a fitted filter on new views");
  compare_command->add_option("scene", compare_options->scene, "an included name, folder or file")
      ->required();
  compare_command->add_option("--weights", compare_options->weights, "files to compare as well");
  add_view_options(*compare_command, *compare_options);
  run(compare_command, compare, compare_options);

  auto info_options = std::make_shared<RecoverOptions>();
  CLI::App* info_command = group->add_subcommand("info", "what a weights file holds");
  info_command->add_option("file", info_options->weights, "weights.qrw")->required()->expected(1);
  run(info_command, info, info_options);
}

}  // namespace qray::cmd
