#include "core/cmd/chart_session.h"

#include "core/cmd/files.h"
#include "core/cmd/render_options.h"
#include "core/image/difference_map.h"
#include "core/image/image_io.h"
#include "core/laboratory/chart/names.h"
#include "core/laboratory/chart/summarize.h"
#include "core/settings/variant.h"

namespace qray::cmd {
namespace {

// Progress over all runs.
class ChartProgress final : public RenderObserver {
 public:
  ChartProgress(ProgressLine& line, std::string label, size_t done, size_t all)
      : line_(line), label_(std::move(label)), done_(done), all_(all) {}
  void on_tile(const RenderProgress& p) override {
    const double runs = static_cast<double>(done_) + p.fraction;
    line_.show(label_, runs / static_cast<double>(all_), samples_words(p.samples_per_pixel),
               p.seconds);
  }

 private:
  ProgressLine& line_;
  const std::string label_;
  const size_t done_, all_;
};

std::string size_text(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

}  // namespace

ChartSession::ChartSession(const ChartOptions& options, const ChartPlan& plan, ChartFile file,
                           std::stop_token stop)
    : options_(options),
      plan_(plan),
      runs_(chart_runs(plan)),
      dir_(options.out),
      file_(std::move(file)),
      stop_(std::move(stop)),
      pool_(options.threads),
      line_(options.quiet) {}

Status ChartSession::load_scenes() {
  for (size_t i = 0; i < plan_.scenes.size(); ++i) {
    Result<std::shared_ptr<const PreparedScene>> scene =
        prepare_named_scene(options_.scenes[i], options_.threads, line_, stop_);
    if (!scene) return scene.error();
    scenes_.push_back({plan_.scenes[i], std::move(scene).value()});
    if (Status s = check(scenes_.back()); !s) return s;
  }
  return {};
}

Status ChartSession::check(const NamedScene& scene) const {
  const ChartReference* measured = file_.reference(scene.name);
  if (measured && measured->scene_hash != scene.prepared->hash.whole().hex())
    return Error{ErrorCode::kConflict,
                 "has changed since the chart was begun. Give another folder, or --fresh",
                 scene.name};
  for (const std::string& method : plan_.methods) {
    const Result<RenderSettings> s =
        apply_variant(method, chart_settings(scene.prepared->scene, plan_));
    if (!s) return s.error();
    if (Status checked = check_settings(s.value(), kMaxPixels); !checked) return checked;
  }
  return {};
}

size_t ChartSession::complete_runs() const {
  return static_cast<size_t>(std::count_if(
      runs_.begin(), runs_.end(), [&](const ChartRun& run) { return file_.has_run(run); }));
}

Status ChartSession::measure() {
  Status status;
  for (size_t i = 0; i < scenes_.size() && status.ok(); ++i) {
    std::vector<ChartRun> missing;
    for (const ChartRun& run : runs_)
      if (run.scene == scenes_[i].name && !file_.has_run(run)) missing.push_back(run);
    if (!missing.empty()) status = measure(scenes_[i], missing);
  }
  line_.finish();
  return status;
}

Status ChartSession::measure(const NamedScene& scene, std::span<const ChartRun> runs) {
  const Result<Image> truth = reference(scene);
  if (!truth) return truth.error();
  if (Status s = write_picture(chart_reference_picture(scene.name), truth.value()); !s) return s;
  for (const ChartRun& run : runs) {
    const std::string label = run.scene + " " + run.method + (run.warm ? " warm " : " ");
    ChartProgress progress(line_, label + std::to_string(run.seed), complete_runs(), all_runs());
    const Result<ChartRunResult> result = measure_run(*scene.prepared, plan_, run, truth.value(),
                                                      pool_, progress, stop_, SteadyClock());
    if (!result) return result.error();
    const auto& [rows, picture] = result.value();
    if (run.seed == plan_.seeds.front()) {
      const std::filesystem::path name = chart_picture(run.scene, run.method, run.warm);
      if (Status s = write_picture(name, picture); !s) return s;
      const std::filesystem::path error = chart_error_picture(run.scene, run.method, run.warm);
      if (Status s = write_picture(error, error_map(picture, truth.value())); !s) return s;
    }
    if (Status s = file_.add(rows); !s) return s;
  }
  return {};
}

Status ChartSession::write_picture(const std::filesystem::path& name, const Image& picture) const {
  std::error_code failed;
  std::filesystem::create_directories((dir_ / name).parent_path(), failed);
  if (failed) return Error{ErrorCode::kIo, failed.message(), (dir_ / name).string()};
  return write_image(dir_ / name, picture);
}

// All runs of a scene in one file are measured against the same one.
Result<Image> ChartSession::reference(const NamedScene& scene) {
  Result<Reference> found = options_.ref.empty() ? own_reference(scene) : given_reference(scene);
  if (!found) return found.error();
  Reference& r = found.value();
  r.about.scene = scene.name;
  const std::filesystem::path inside = std::filesystem::path(r.about.path).lexically_relative(dir_);
  if (!inside.empty() && *inside.begin() != "..") r.about.path = inside.string();
  if (!file_.reference(scene.name))
    if (Status s = file_.add(r.about); !s) return s.error();
  return std::move(r.picture);
}

// From the cache, or rendered.
Result<Reference> ChartSession::own_reference(const NamedScene& scene) {
  RenderSettings settings = chart_settings(scene.prepared->scene, plan_);
  settings.method = options_.ref_method;
  settings.seconds = *options_.ref_seconds;
  const std::filesystem::path path = reference_path(
      options_.ref_cache.empty() ? dir_ / "references" : std::filesystem::path(options_.ref_cache),
      scene.name, *scene.prepared, settings);
  Result<std::optional<Reference>> found = find_reference(path, settings.seconds);
  if (!found) return found.error();
  const ChartReference* used = file_.reference(scene.name);
  if (used && (!found.value() || found.value()->about.floor_relmse != used->floor_relmse))
    return Error{ErrorCode::kConflict,
                 "expected the reference that the chart was begun with. Put it back, give another "
                 "folder, or --fresh",
                 path.string()};
  if (found.value()) return std::move(*found.value());
  ChartProgress progress(line_, scene.name + " reference", complete_runs(), all_runs());
  return make_reference(path, *scene.prepared, settings, pool_, progress, stop_, SteadyClock());
}

Result<Reference> ChartSession::given_reference(const NamedScene& scene) const {
  Result<Image> picture = read_linear_image(options_.ref);
  if (!picture) return picture.error();
  const RenderSettings s = chart_settings(scene.prepared->scene, plan_);
  Reference r;
  r.picture = std::move(picture).value();
  r.about.scene_hash = scene.prepared->hash.whole().hex();
  r.about.width = r.picture.width();
  r.about.height = r.picture.height();
  r.about.path = options_.ref;
  r.about.floor_known = false;
  if (r.about.width == s.width && r.about.height == s.height) return r;
  return Error{ErrorCode::kInvalid,
               "is " + size_text(r.about.width, r.about.height) + ", expected " +
                   size_text(s.width, s.height),
               options_.ref};
}

ChartSummary ChartSession::summarize() const {
  const ChartHeader& h = file_.header();
  ChartSummary s{h.command,   h.commit,     h.machine,     h.date,      options_.threads,
                 plan_.width, plan_.height, plan_.seconds, plan_.seeds, {}};
  const size_t series = runs_.size() / plan_.seeds.size();  // of all scenes
  for (const NamedScene& scene : scenes_) {
    std::vector<ChartRow> rows;
    for (const ChartRow& row : file_.rows())
      if (row.scene == scene.name) rows.push_back(row);
    s.scenes.push_back(
        summarize_scene(*file_.reference(scene.name), rows, static_cast<int>(series)));
  }
  return s;
}

}  // namespace qray::cmd
