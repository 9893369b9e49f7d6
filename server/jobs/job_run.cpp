#include "server/jobs/job_run.h"

#include <spdlog/spdlog.h>

#include "core/job/stats_json.h"
#include "core/recover/included_networks.h"
#include "proto/events.h"
#include "server/jobs/job_history.h"
#include "server/jobs/job_settings.h"
#include "server/jobs/load_ticker.h"
#include "server/jobs/progress_ticker.h"
#include "server/operation/metrics.h"

namespace qray::server {
namespace {

constexpr size_t kMaxTablesTried = 8;

bool learns(const RenderSettings& settings) {
  return settings.method != "none" && settings.learning_samples > 0;
}

// Bytes of the film, its noise and the table at most; of a network's work on the picture.
size_t memory_needed(const RenderSettings& settings, bool recovers) {
  constexpr size_t kPixelBytes = 110, kRecoveryBytes = 160;
  const size_t pixels = static_cast<size_t>(settings.width) * static_cast<size_t>(settings.height);
  return pixels * (kPixelBytes + (recovers ? kRecoveryBytes : 0)) +
         (learns(settings) ? settings.max_table_bytes : 0);
}

}  // namespace

Status JobRun::move(JobState to, const JobStore::Change& change) {
  Result<JobRecord> moved = context_.stores.jobs.move(id_, to, change);
  if (moved.ok()) {
    job_ = std::move(moved).value();
    return {};
  }
  if (moved.error().code == ErrorCode::kConflict) {
    return Error{ErrorCode::kCanceled, "canceled", ""};
  }
  return moved.error();
}

void JobRun::run(const std::function<bool()>& stopping) {
  Status done;
  try {
    done = move(JobState::kPreparing);
    if (!done.ok() && done.error().code == ErrorCode::kCanceled) return;  // before it began
    if (done.ok()) done = prepare();
    if (done.ok()) {
      Result<Rendered> rendered = render();
      done = rendered.ok() ? finish(std::move(rendered).value()) : Status(rendered.error());
    }
  } catch (const std::bad_alloc&) {
    done = Error{ErrorCode::kTooLarge, "there is not enough memory for this job", ""};
  } catch (const std::exception& e) {
    spdlog::error("job={} exception: {}", id_.text(), e.what());
    done = Error{ErrorCode::kIo, "internal error; the server's log has more", ""};
  }
  if (!done.ok()) end(done.error(), stopping);
}

Status JobRun::prepare() {
  LoadTicker ticker(context_.stores.jobs, id_, context_.clock, context_.stop);
  Result<std::shared_ptr<const PreparedScene>> scene =
      context_.stores.scenes.prepare(job_.request.scene, ticker.watch());
  if (!scene.ok()) return context_.stores.scenes.without_folder(scene.error());
  scene_ = std::move(scene).value();
  for (const std::string& warning : scene_->warnings) warn(warning);
  settings_ = settings_of(job_.request, scene_->scene);
  settings_.max_table_bytes = context_.stores.tables.max_bytes();
  settings_.estimates_noise = true;  // for who looks at it
  if (Status s = check_settings(settings_, kMaxPicturePixels); !s.ok()) return s;
  memory_ =
      context_.memory.take(memory_needed(settings_, job_.request.recover != "none"), context_.stop);
  if (context_.stop.stop_requested()) return Error{ErrorCode::kCanceled, "canceled", ""};

  show_film();
  JobStore::Change resolved;
  resolved.edit = [&](JobRecord& job) {
    job.request.width = settings_.width;
    job.request.height = settings_.height;
    job.request.max_depth = settings_.max_depth;
  };
  return move(learns(settings_) ? JobState::kLearning : JobState::kRendering, resolved);
}

void JobRun::show_film() {
  live_ = std::make_shared<LiveJob>(id_, std::make_shared<Film>(settings_.width, settings_.height));
  context_.show(live_);
}

void JobRun::warn(std::string text) {
  context_.stores.jobs.log(id_, "warning", text);
  warnings_.push_back(std::move(text));
}

void JobRun::log(std::string_view text) { context_.stores.jobs.log(id_, "info", text); }

// What an interrupted run of this job left, if it fits.
std::optional<Checkpoint> JobRun::checkpoint() {
  Result<Checkpoint> checkpoint = context_.stores.checkpoints.load(id_);
  if (!checkpoint.ok() && checkpoint.error().code == ErrorCode::kNotFound) return {};
  std::string why;
  if (!checkpoint.ok()) {
    why = checkpoint.error().text();
  } else if (checkpoint.value().header.scene_hash != scene_->hash.whole().hex()) {
    why = "the scene has changed";
  } else {
    return std::move(checkpoint).value();
  }
  warn("the job starts anew, as what it had rendered is of no use: " + why);
  context_.stores.checkpoints.remove(id_);
  return {};
}

Result<JobRun::Rendered> JobRun::render() {
  context_.keeper.on_first_save([this] { (void)context_.stores.jobs.reset_attempts(id_); });
  if (const std::optional<Checkpoint> found = checkpoint()) {
    Result<Rendered> rendered = go_on(*found);
    if (rendered.ok() || rendered.error().code != ErrorCode::kCorrupt) return rendered;
    warn("the job starts anew, as what it had rendered cannot be read");
    context_.stores.checkpoints.remove(id_);
    show_film();
  }
  return render_from_start();
}

Result<JobRun::Rendered> JobRun::go_on(const Checkpoint& checkpoint) {
  log("going on from a checkpoint");
  const CheckpointHeader& header = checkpoint.header;
  warnings_ = header.warnings;
  std::optional<TableFile> table;
  if (!header.table_in.empty()) {  // what it held is in the checkpoint
    table.emplace();
    table->header.id = header.table_in;
    table->header.method = table_method(settings_.method);
  }
  SnapshotReader state = checkpoint.state();
  return render_job(std::move(table), header.recovery.empty() ? "none" : header.recovery, &state);
}

Result<JobRun::Rendered> JobRun::render_from_start() {
  const std::string& wanted = job_.request.table;
  if (settings_.method == "none" || wanted == "none") return render_with(std::nullopt);
  if (wanted == "auto") return render_from_fitting();
  Result<TableFile> table = context_.stores.tables.load(wanted);
  if (!table.ok()) return table.error();
  if (!table_fits(table.value().header, scene_->hash)) {
    return Error{ErrorCode::kConflict,
                 "table " + wanted +
                     " was learned from another scene: expected the same geometry, "
                     "materials and lights",
                 "/table"};
  }
  return render_with(std::move(table).value());
}

Result<JobRun::Rendered> JobRun::render_with(std::optional<TableFile> table) {
  return render_job(std::move(table), job_.request.recover, nullptr);
}

Result<JobRun::Rendered> JobRun::render_job(std::optional<TableFile> table,
                                            const std::string& wanted,
                                            SnapshotReader* resume_from) {
  const ProgressTicker ticker(context_.stores.jobs, *live_, learns(settings_));
  const std::string id = table ? table->header.id : std::string();
  warm_ = !id.empty();
  if (warm_) log("from table " + id);
  if (!resume_from) context_.stores.histories.remove(id_);
  std::optional<TableHeader> parent;
  if (table) parent = table->header;
  JobHistory history(context_.stores.histories, id_, live_->film(),
                     [&](const Guide& guide) { return table_of(guide, scene_->hash, parent); });
  live_->on_pass([&](const RenderProgress& progress, const RenderStats& stats, const Guide* guide) {
    last_pass_ = stats;
    history.add(progress, stats, guide);
  });
  const std::optional<Recovery> recovery = this->recovery(wanted);
  context_.keeper.start(
      {scene_->hash.whole().hex(), id, recovery ? recovery->name : std::string(), warnings_});
  Result<JobResult> result = run_job(
      *scene_, settings_, std::move(table), live_->film(), context_.pool, *live_, context_.stop,
      context_.clock, recovery ? &*recovery : nullptr, {&context_.keeper, resume_from});
  live_->on_pass(nullptr);
  if (!history.failure().empty()) warn(history.failure());
  if (!result.ok()) return result.error();
  return Rendered{std::move(result).value(), id};
}

// The network that the job asks for. One that cannot be read is no reason to fail: the untrained
// one serves, and the job says so.
std::optional<Recovery> JobRun::recovery(std::string wanted) {
  if (wanted == "none") return {};
  WeightsStore& store = context_.stores.weights;
  if (wanted == "auto") wanted = store.fitting(scene_->hash).value_or("default");
  if (Result<Network> included = included_network(wanted); included.ok())
    return Recovery{wanted, std::move(included).value()};
  Result<WeightsFile> weights = store.load(wanted);
  if (weights.ok()) return Recovery{wanted, std::move(weights.value().network)};
  warn("weights " + wanted +
       " were not used, but an untrained network: " + weights.error().message);
  return Recovery{"untrained", included_network("untrained").value()};
}

// The newest table that this job can use. One that cannot be read goes to quarantine; one of
// another grid or too large is passed over. All are refused before anything is rendered.
Result<JobRun::Rendered> JobRun::render_from_fitting() {
  TableStore& tables = context_.stores.tables;
  Result<std::vector<std::string>> ids =
      tables.fitting(table_method(settings_.method), scene_->hash, kMaxTablesTried);
  if (!ids.ok()) return ids.error();
  for (const std::string& id : ids.value()) {
    Result<TableFile> table = tables.load(id);
    if (!table.ok()) {
      warn("table " + id + " was not used: " + table.error().message);
      continue;
    }
    Result<Rendered> rendered = render_with(std::move(table).value());
    if (rendered.ok() || live_->film().version() > 0) return rendered;
    const Error& error = rendered.error();
    const bool passed_over =
        error.code == ErrorCode::kConflict || error.code == ErrorCode::kTooLarge;
    if (error.code != ErrorCode::kCorrupt && !passed_over) return rendered;
    warn("table " + id + " was not used: " + error.message);
    if (error.code == ErrorCode::kCorrupt) {
      if (Status s = tables.quarantine(id); !s.ok()) return s.error();
    }
  }
  return render_with(std::nullopt);
}

Status JobRun::finish(Rendered rendered) {
  const double begin = context_.clock.seconds();
  const RenderStats& stats = rendered.result.stats;
  // A short job's learning may have ended between two looks at it.
  if (job_.state == JobState::kLearning) (void)move(JobState::kRendering);
  if (Status s = move(JobState::kFinalizing); !s.ok()) return s;
  if (!context_.keeper.failure().empty())
    warn("the job's state could not be written: " + context_.keeper.failure());
  if (const std::optional<Image>& recovered = rendered.result.recovered) {
    if (Status s = context_.stores.results.save_recovered(id_, *recovered,
                                                          rendered.result.recovered_metadata);
        !s.ok()) {
      return s;
    }
  }
  if (Status s = context_.stores.results.save(id_, live_->film(), rendered.result.metadata);
      !s.ok()) {
    return s;
  }
  context_.show(nullptr);  // who sees the job ended finds the finished picture, not the forming one
  const std::optional<TableFile>& table = rendered.result.table;
  const bool keep_table = table && job_.request.table != "none";
  JobStore::Change change;
  if (keep_table) {
    Result<uint64_t> bytes = context_.stores.tables.write(*table);
    if (!bytes.ok()) return bytes.error();
    const TableHeader& header = table->header;
    change.events.push_back(
        {0, id_.text(), "table", proto::table_event(id_.text(), header.id, header.parents)});
    change.also = [&, bytes = bytes.value()](Database::Session& session) {
      return TableStore::record(
          session, *table,
          {header.id, job_.request.scene, header.method, header.parents, context_.now_ms(), bytes,
           stats.states, header.samples_seen, id_.text()});
    };
  }
  change.edit = [&](JobRecord& job) {
    job.progress = {1, stats.samples_per_pixel, stats.seconds};
    job.table_in = rendered.table_in;
    if (keep_table) job.table_out = table->header.id;
    job.stats_json = stats_json(stats, /*indent=*/false);
    job.biased = !stats.unbiased || rendered.result.recovered;
    job.warnings = warnings_;
  };
  context_.stores.checkpoints.finished(id_);  // before anyone can ask whether it is extendable
  const Status succeeded = move(JobState::kSucceeded, change);
  if (!succeeded.ok()) return succeeded;
  if (Metrics* metrics = context_.stores.metrics)
    metrics->add_job(stats, context_.clock.seconds() - begin, !rendered.table_in.empty());
  return succeeded;
}

void JobRun::keep_partial_picture() {
  if (!live_ || live_->film().version() == 0) return;
  const ImageMetadata metadata = {{"scene", job_.request.scene},
                                  {"method", settings_.method},
                                  {"seed", std::to_string(settings_.seed)},
                                  {"unfinished", "true"}};
  if (Status s = context_.stores.results.save(id_, live_->film(), metadata); !s.ok()) {
    spdlog::error("job={} the picture is lost: {}", id_.text(), s.error().text());
  }
}

void JobRun::end(const Error& error, const std::function<bool()>& stopping) {
  const Result<JobRecord> now = context_.stores.jobs.get(id_);
  const auto is = [&](JobState state) { return now.ok() && now.value().state == state; };
  JobStore::Change change;
  JobState to = JobState::kFailed;
  if (is(JobState::kCanceling)) {
    to = JobState::kCanceled;
  } else if (is(JobState::kPausing) && error.code == ErrorCode::kCanceled) {
    to = JobState::kPaused;
  } else if (stopping() && error.code == ErrorCode::kCanceled) {
    to = JobState::kQueued;
  }
  if (to != JobState::kQueued) keep_partial_picture();
  if (has_ended(to)) context_.stores.checkpoints.remove(id_);
  context_.show(nullptr);
  change.edit = [&](JobRecord& job) {
    if (live_) job.progress = live_->progress();
    job.warnings = warnings_;
    if (to == JobState::kFailed) job.error = proto::JobError{error.message, error.where};
    if (to == JobState::kQueued || to == JobState::kPaused)
      job.attempts = std::max(0, job.attempts - 1);  // an orderly stop is not the job's fault
  };
  constexpr std::chrono::seconds kAgain{1};
  bool told = false;
  for (;;) {
    Result<JobRecord> moved = context_.stores.jobs.move(id_, to, change);
    // It may have become canceling since the look above, or pausing.
    for (JobState other : {JobState::kPaused, JobState::kCanceled})
      if (!moved.ok() && moved.error().code == ErrorCode::kConflict)
        moved = context_.stores.jobs.move(id_, other, change);
    if (moved.ok()) {
      if (Metrics* metrics = context_.stores.metrics; metrics && has_ended(to) && last_pass_)
        metrics->add_job(*last_pass_, 0, warm_);
      return;
    }
    if (!told) {
      spdlog::error("job={} its end cannot be recorded: {}", id_.text(), moved.error().text());
    }
    told = true;
    // A disk that is full may have room again; at the next start the job is taken up anyway.
    if (moved.error().code != ErrorCode::kIo || stopping()) return;
    std::this_thread::sleep_for(kAgain);
  }
}

}  // namespace qray::server
