#include "core/laboratory/chart/chart_run.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/image/metrics.h"
#include "core/job/recover_picture.h"
#include "core/job/run_job.h"
#include "core/settings/variant.h"

namespace qray {
namespace {

constexpr int kChartTimes = 16;  // 2^(16/2) = 256 from the first time to the budget
constexpr uint64_t kTeacherSeed = uint64_t{1} << 32;  // added: never a measured seed

// Stops between passes. Not read by workers while it is stopped or started.
class PausableClock final : public Clock {
 public:
  explicit PausableClock(const Clock& clock) : clock_(clock) {}
  double seconds() const override { return (paused_at_ ? *paused_at_ : clock_.seconds()) - lost_; }
  void pause() { paused_at_ = clock_.seconds(); }
  void resume() {
    lost_ += clock_.seconds() - *paused_at_;
    paused_at_.reset();
  }

 private:
  const Clock& clock_;
  std::optional<double> paused_at_;
  double lost_ = 0;
};

// The picture of a run as it is now, and what it took to recover it.
struct Developed {
  Image picture;
  double seconds = 0;
};
using Develop = std::function<Result<Developed>()>;

// By the network that the settings name.
Result<Develop> developer(const PreparedScene& scene, const RenderSettings& settings,
                          const Film& film, TaskPool& pool, std::stop_token stop,
                          const Clock& clock) {
  if (settings.recover == "none")
    return Develop([&film]() -> Result<Developed> { return Developed{film.develop()}; });
  Result<Recovery> recovery = included_recovery(settings.recover);
  if (!recovery) return recovery.error();
  if (Status s = check_recovery(recovery.value(), settings); !s) return s.error();
  return Develop([&scene, &film, &pool, &clock, settings, stop,
                  by = std::move(recovery).value()]() -> Result<Developed> {
    const double start = clock.seconds();
    Result<Recovered> recovered = recover_picture(scene, settings, by, film, pool, stop);
    if (!recovered) return recovered.error();
    return Developed{std::move(recovered.value().picture), clock.seconds() - start};
  });
}

// Makes the rows of a run while it is rendered.
class PictureSampler final : public RenderObserver {
 public:
  PictureSampler(Develop develop, const Image& reference, ChartRow label, double seconds,
                 PausableClock& clock, RenderObserver& next)
      : develop_(std::move(develop)),
        reference_(reference),
        label_(std::move(label)),
        times_(chart_times(seconds)),
        clock_(clock),
        next_(next) {}

  void on_tile(const RenderProgress& progress) override { next_.on_tile(progress); }
  void on_pass(const RenderProgress& progress, const RenderStats& so_far,
               const Guide* guide) override {
    clock_.pause();
    next_.on_pass(progress, so_far, guide);
    const auto after = std::upper_bound(times_.begin(), times_.end(), so_far.seconds);
    const int passed = static_cast<int>(after - times_.begin());
    if (passed > passed_ && status_.ok()) look(so_far, passed - 1);
    passed_ = passed;
    clock_.resume();
  }

  // Rows up to the end, whose picture may have been looked at already.
  Result<ChartRunResult> finish(const RenderStats& stats) {
    if (!rows_.empty() && rows_.back().samples_per_pixel == stats.samples_per_pixel)
      rows_.pop_back();
    if (status_.ok()) look(stats, kChartTimes);
    if (!status_.ok()) return status_.error();
    rows_.back().last = true;
    return ChartRunResult{std::move(rows_), std::move(picture_)};
  }

 private:
  void look(const RenderStats& stats, int point) {
    Result<Developed> developed = develop_();
    if (!developed) {
      status_ = developed.error();
      return;
    }
    picture_ = std::move(developed.value().picture);
    const Result<ImageDifference> difference = image_difference(picture_, reference_);
    if (!difference) {
      status_ = difference.error();
      return;
    }
    const ImageDifference& d = difference.value();
    ChartRow row = label_;
    row.point = point;
    row.seconds = stats.seconds + developed.value().seconds;
    row.samples_per_pixel = stats.samples_per_pixel;
    row.rays = stats.rays;
    row.dropped_samples = stats.dropped_samples;
    row.relmse = d.relmse;
    row.relmse_trimmed = d.relmse_trimmed;
    row.flip = d.flip;
    row.mean_ratio = d.mean_ratio;
    row.states = stats.states;
    row.table_bytes = stats.table_bytes;
    rows_.push_back(std::move(row));
  }

  const Develop develop_;
  const Image& reference_;
  const ChartRow label_;
  const std::vector<double> times_;
  PausableClock& clock_;
  RenderObserver& next_;
  int passed_ = 0;  // of times_
  std::vector<ChartRow> rows_;
  Image picture_;  // the last that was looked at
  Status status_;
};

}  // namespace

std::vector<ChartRun> chart_runs(const ChartPlan& plan) {
  std::vector<ChartRun> runs;
  for (const std::string& scene : plan.scenes)
    for (size_t round = 0; round < plan.seeds.size(); ++round)
      for (size_t i = 0; i < plan.methods.size(); ++i) {
        const std::string& method = plan.methods[(i + round) % plan.methods.size()];
        runs.push_back({scene, method, false, plan.seeds[round]});
        if (plan.warm && method_traits(method).keeps_table)
          runs.push_back({scene, method, true, plan.seeds[round]});
      }
  return runs;
}

std::vector<double> chart_times(double seconds) {
  std::vector<double> times;
  for (int k = 0; k < kChartTimes; ++k)
    times.push_back(seconds * std::exp2((k - kChartTimes) / 2.0));
  return times;
}

Camera turned(const Camera& camera, float degrees) {
  const Vec3 ahead = camera.target - camera.position, axis = normalize(camera.up);
  const float angle = degrees * (kPi / 180);
  Camera out = camera;
  out.target = camera.position + ahead * std::cos(angle) + cross(axis, ahead) * std::sin(angle) +
               axis * (dot(axis, ahead) * (1 - std::cos(angle)));
  return out;
}

RenderSettings chart_settings(const Scene& scene, const ChartPlan& plan) {
  RenderSettings settings;
  settings.width = plan.width > 0 ? plan.width : scene.width;
  settings.height = plan.height > 0 ? plan.height : scene.height;
  settings.max_depth = scene.max_depth;
  settings.samples = 0;
  settings.seconds = plan.seconds;
  return settings;
}

Result<ChartRunResult> measure_run(const PreparedScene& scene, const ChartPlan& plan,
                                   const ChartRun& run, const Image& reference, TaskPool& pool,
                                   RenderObserver& observer, std::stop_token stop,
                                   const Clock& clock) {
  const Result<RenderSettings> made = apply_variant(run.method, chart_settings(scene.scene, plan));
  if (!made) return made.error();
  RenderSettings settings = made.value();
  std::optional<TableFile> table;
  if (run.warm) {
    RenderSettings teacher = settings;
    teacher.seed = run.seed + kTeacherSeed;
    teacher.camera = turned(scene.scene.camera, plan.warm_turn_deg);
    Film unseen(settings.width, settings.height);
    Result<JobResult> job =
        run_job(scene, teacher, std::nullopt, unseen, pool, observer, stop, clock);
    if (!job) return job.error();
    table = std::move(job).value().table;
  }

  settings.seed = run.seed;
  settings.estimates_noise |= settings.recover != "none";
  Film film(settings.width, settings.height);
  const Result<Develop> develop = developer(scene, settings, film, pool, stop, clock);
  if (!develop) return develop.error();
  PausableClock pausable(clock);
  ChartRow label;
  label.scene = run.scene;
  label.method = run.method;
  label.warm = run.warm;
  label.seed = run.seed;
  PictureSampler sampler(develop.value(), reference, label, plan.seconds, pausable, observer);
  const Result<JobResult> job =
      run_job(scene, settings, std::move(table), film, pool, sampler, stop, pausable);
  if (!job) return job.error();
  return sampler.finish(job.value().stats);
}

}  // namespace qray
