#include "server/jobs/pass_helper.h"

#include <spdlog/spdlog.h>

#include "core/render/light_mix.h"
#include "core/settings/job_settings.h"
#include "server/jobs/bits_of_machine.h"
#include "server/jobs/unit_loop.h"
#include "server/jobs/wait.h"
#include "server/policy/memory_needed.h"

namespace qray::server {
namespace {

using std::chrono::milliseconds;
constexpr milliseconds kLookForJobs{300}, kLeastBetweenLooks{5}, kMostBetweenLooks{100};
constexpr double kNothingNew = 30;  // seconds without a pass: its owner may be gone

}  // namespace

void PassHelper::run(const std::stop_token& stop) {
  const std::string bits = bits_of_machine();
  bool told = false;
  for (; !stop.stop_requested(); wait_unless(stop, kLookForJobs)) {
    if (!uses_.is_free()) continue;
    const Result<std::optional<SharedPasses::Open>> found = uses_.passes.find(bits);
    if (!found.ok() || !found.value()) continue;
    const SharedPasses::Open job = *found.value();
    if (const Result<bool> joined = uses_.passes.join(job); !joined.ok() || !joined.value())
      continue;
    {
      std::lock_guard lock(mutex_);
      helps_ = job.job;
    }
    spdlog::info("job={} helps with its passes", job.job.text());
    Status helped;
    try {
      helped = help(job, stop);
    } catch (const std::exception& e) {
      helped = Error{ErrorCode::kIo, e.what(), ""};
    }
    {
      std::lock_guard lock(mutex_);
      helps_.reset();
    }
    (void)uses_.passes.leave(job);
    spdlog::info("job={} helps no more", job.job.text());
    if (!helped.ok() && !std::exchange(told, true))
      spdlog::error("job={} cannot be helped: {}", job.job.text(), helped.error().text());
    if (helped.ok()) told = false;
    // What failed once may do so each time.
    if (!helped.ok()) wait_unless(stop, std::chrono::seconds(5));
  }
}

std::optional<JobId> PassHelper::helps() const {
  std::lock_guard lock(mutex_);
  return helps_;
}

Status PassHelper::help(const SharedPasses::Open& job, const std::stop_token& stop) {
  const Result<JobRecord> record = uses_.jobs.get(job.job);
  if (!record.ok()) return record.error();
  const JobRequest& request = record.value().request;
  const Result<std::shared_ptr<const PreparedScene>> scene =
      uses_.scenes.prepare(request.get(field::kScene), {});
  if (!scene.ok()) return scene.error();
  RenderSettings settings = settings_of(request, scene.value()->scene);
  settings.max_table_bytes = uses_.tables.max_bytes();
  const Result<std::shared_ptr<const PreparedScene>> lit = lit_by_mix(scene.value(), settings);
  if (!lit.ok()) return lit.error();
  const Result<LightSplit> split = light_split(lit.value()->scene, settings);
  if (!split.ok()) return split.error();
  const MemoryBudget::Part memory =
      uses_.memory.take(job_memory(settings, false, split.value().layers), stop);
  if (stop.stop_requested()) return {};
  return sample_passes(job, *lit.value(), settings, stop);
}

Status PassHelper::sample_passes(const SharedPasses::Open& job, const PreparedScene& scene,
                                 const RenderSettings& settings, const std::stop_token& stop) {
  TaskPool share(uses_.pool, 1);
  Result<std::unique_ptr<UnitRenderer>> renderer = UnitRenderer::make(scene, settings, share);
  if (!renderer.ok()) return renderer.error();
  std::atomic<bool> late = false;  // the pass is over
  UnitLoop loop(uses_.passes, *renderer.value(), uses_.clock,
                [&](const SharedPasses::Pass& pass, SharedPasses::Unit unit) {
                  const Result<SharedPasses::Put> put = uses_.passes.put(pass.key, unit);
                  if (put.ok() && put.value() == SharedPasses::Put::kLate) late = true;
                });
  std::optional<SharedPasses::Pass> pass;
  milliseconds between = kLeastBetweenLooks;
  double last = uses_.clock.seconds();
  while (!stop.stop_requested() && uses_.is_free() && uses_.clock.seconds() - last < kNothingNew) {
    Result<std::optional<SharedPasses::Pass>> next =
        uses_.passes.next(job, pass ? std::optional(pass->key) : std::nullopt);
    if (!next.ok()) return next.error();
    if (next.value()) {
      // Between two looks it may have become yet another one: then its guide is gone.
      if (!loop.start(*next.value())) {
        wait_unless(stop, between);
        continue;
      }
      pass = std::move(next).value();
      late = false;
    }
    size_t sampled = 0;
    if (pass && !late) {
      const uint64_t before = renderer.value()->paths();
      sampled = loop.run(
          *pass, [&] { return !late && uses_.is_free(); }, stop);
      samples_ += renderer.value()->paths() - before;
    }
    if (sampled > 0 || next.value()) {
      last = uses_.clock.seconds();
      between = kLeastBetweenLooks;
      continue;
    }
    wait_unless(stop, between);
    between = std::min(2 * between, kMostBetweenLooks);
    if (between < kMostBetweenLooks) continue;
    // It may have ended.
    const Result<bool> goes_on = uses_.passes.join(job);
    if (!goes_on.ok()) return goes_on.error();
    if (!goes_on.value()) return {};
  }
  return {};
}

}  // namespace qray::server
