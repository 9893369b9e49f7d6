#include "server/jobs/job_run.h"

#include <spdlog/spdlog.h>

#include "core/job/stats_json.h"
#include "core/recover/included_networks.h"
#include "core/render/light_mix.h"
#include "core/settings/job_settings.h"
#include "proto/events.h"
#include "server/jobs/job_frames.h"
#include "server/jobs/job_moments.h"
#include "server/jobs/load_ticker.h"
#include "server/jobs/progress_ticker.h"
#include "server/jobs/wait.h"
#include "server/operation/metrics.h"
#include "server/policy/memory_needed.h"
#include "server/policy/network_choice.h"
#include "server/policy/table_choice.h"

namespace qray::server {
namespace {

constexpr const char* kOtherBuild =
    "this job goes on from what another build of qray rendered; its bits may differ from an "
    "undisturbed run";

}  // namespace

Status JobRun::try_move(JobState to, const JobStore::Change& change) {
  JobStore::Change mine = change;
  if (to != JobState::kPreparing) mine.claim = job_.claim;
  Result<JobRecord> moved = context_.stores.jobs.move(id_, to, mine);
  if (moved.ok()) {
    job_ = std::move(moved).value();
    return {};
  }
  if (moved.error().code == ErrorCode::kConflict) {
    return Error{ErrorCode::kCanceled, "canceled", ""};
  }
  return moved.error();
}

Status JobRun::move(JobState to, const JobStore::Change& change) {
  for (;;) {
    Status moved = try_move(to, change);
    if (moved.ok() || moved.error().code != ErrorCode::kIo ||
        !wait_for_disk(moved.error(), context_.stop))
      return moved;
  }
}

bool JobRun::wait_for_disk(const Error& error, const std::stop_token& stop) {
  if (!std::exchange(disk_failed_, true))
    spdlog::error("job={} waits, as its state cannot be recorded: {}", id_.text(), error.text());
  return wait_unless(stop, kDiskAgain);
}

void JobRun::run() {
  Status done;
  counted_ = job_.stats_json;
  try {
    done = prepare();
    if (done.ok()) {
      Result<Rendered> rendered = resume_or_begin();
      done = rendered.ok() ? finish(std::move(rendered).value()) : Status(rendered.error());
    }
  } catch (const std::bad_alloc&) {
    done = Error{ErrorCode::kTooLarge, "there is not enough memory for this job", ""};
  } catch (const std::exception& e) {
    spdlog::error("job={} exception: {}", id_.text(), e.what());
    done = Error{ErrorCode::kIo, "internal error; the server's log has more", ""};
  }
  if (!done.ok()) end(done.error());
}

Status JobRun::prepare() {
  LoadTicker ticker(context_.stores.jobs, id_, context_.clock, context_.stop);
  Result<std::shared_ptr<const PreparedScene>> scene =
      context_.stores.scenes.prepare(job_.request.get(field::kScene), ticker.watch());
  if (!scene.ok()) return context_.stores.scenes.without_folder(scene.error());
  scene_ = std::move(scene).value();
  for (const std::string& warning : scene_->warnings) warn(warning);
  settings_ = settings_of(job_.request, scene_->scene);
  settings_.max_table_bytes = context_.stores.tables.max_bytes();
  settings_.estimates_noise = true;  // for who looks at it
  if (Status s = check_settings(settings_, kMaxPicturePixels); !s.ok()) return s;
  Result<std::shared_ptr<const PreparedScene>> lit = lit_by_mix(scene_, settings_);
  if (!lit.ok()) return lit.error();
  scene_ = std::move(lit).value();
  const Result<LightSplit> split = light_split(scene_->scene, settings_);
  if (!split.ok()) return split.error();
  Result<std::vector<JobFrame>> frames = frames_of(job_.request, scene_->scene);
  if (!frames.ok()) return frames.error();
  frames_ = std::move(frames).value();
  of_frames_ = asks_for_frames(job_.request);
  // Where others sample passes with it, it has a copy of the table beside it.
  const bool shares = job_.request.given(field::kWorkers).value_or(1) != 1;
  const bool moves = frames_.front().seconds && scene_->scene.moves_surfaces;
  memory_ = context_.memory.take(
      job_memory(settings_, job_.request.get(field::kRecover) != "none", split.value().layers) +
          (shares ? table_memory(settings_) : 0) +
          (moves ? moved_memory(settings_, scene_->size_bytes()) : 0),
      context_.stop);
  if (context_.stop.stop_requested()) return Error{ErrorCode::kCanceled, "canceled", ""};

  show_film();
  JobStore::Change resolved;
  resolved.edit = [&](JobRecord& job) {
    job.request.set(field::kWidth, settings_.width);
    job.request.set(field::kHeight, settings_.height);
    job.request.set(field::kMaxDepth, settings_.max_depth);
    complete_frames(job.request, scene_->scene);
  };
  return move(learns(settings_) ? JobState::kLearning : JobState::kRendering, resolved);
}

void JobRun::show_film() {
  running_ =
      std::make_shared<RunningJob>(id_, light_split(scene_->scene, settings_).value().groups);
  if (!of_frames_)
    running_->show(0,
                   std::make_shared<Film>(settings_.width, settings_.height,
                                          film_layers(scene_->scene, settings_)),
                   {});
  context_.show(running_);
}

void JobRun::warn(std::string text) {
  if (context_.lease.holds()) context_.stores.jobs.log(id_, "warning", text);
  warnings_.push_back(std::move(text));
}

void JobRun::log(std::string_view text) {
  if (context_.lease.holds()) context_.stores.jobs.log(id_, "info", text);
}

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

Result<JobRun::Rendered> JobRun::resume_or_begin() {
  context_.keeper.on_first_save([this] {
    (void)context_.stores.jobs.reset_attempts(id_);
    context_.got_somewhere();
  });
  if (const std::optional<Checkpoint> found = checkpoint()) {
    std::vector<std::string> warnings = warnings_;
    Result<Rendered> rendered = resume(*found);
    if (rendered.ok() || rendered.error().code != ErrorCode::kCorrupt) return rendered;
    warnings_ = std::move(warnings);
    mixed_builds_ = false;
    warn("the job starts anew, as what it had rendered cannot be read");
    context_.stores.checkpoints.remove(id_);
    show_film();
  }
  return begin();
}

Result<JobRun::Rendered> JobRun::resume(const Checkpoint& checkpoint) {
  log("going on from a checkpoint");
  const CheckpointHeader& header = checkpoint.header;
  warnings_ = header.warnings;
  mixed_builds_ = header.mixed_builds || checkpoint.other_build;
  if (checkpoint.other_build) {
    if (header.mixed_builds) {
      log(kOtherBuild);  // among the warnings already
    } else {
      warn(kOtherBuild);
    }
  }
  Result<std::unique_ptr<Guide>> guide =
      make_guide(settings_.method, scene_->guide_setup(settings_));
  if (!guide.ok()) return guide.error();
  StartingGuide start{std::move(guide).value(), {}};
  if (!header.table_in.empty()) {  // what it held is in the checkpoint
    start.table.emplace();
    start.table->id = header.table_in;
    start.table->method = table_method(settings_.method);
  }
  SnapshotReader state = checkpoint.state();
  return run_to_end(std::move(start), header.recovery.empty() ? "none" : header.recovery, &state);
}

Result<JobRun::Rendered> JobRun::begin() {
  Result<StartingGuide> start =
      choose_table(context_.stores.tables, *scene_, settings_, {job_.request.get(field::kTable)},
                   [this](std::string text) { warn(std::move(text)); });
  if (!start.ok()) return start.error();
  return run_to_end(std::move(start).value(), job_.request.get(field::kRecover), nullptr);
}

Result<JobRun::Rendered> JobRun::run_to_end(StartingGuide start, const std::string& network,
                                            SnapshotReader* resume_from) {
  const ProgressTicker ticker(context_.stores.jobs, *running_, job_.claim, context_.lease,
                              learns(settings_), of_frames_);
  const Parent parent = start.table;
  const std::string id = parent ? parent->id : std::string();
  warm_ = !id.empty();
  if (warm_) log("from table " + id);
  if (!resume_from && context_.lease.holds()) context_.stores.moments.remove(id_);
  const std::optional<Recovery> recovery = this->recovery(network);
  context_.keeper.start({scene_->hash.whole().hex(), id, recovery ? recovery->name : std::string(),
                         warnings_, mixed_builds_});
  const Recovery* with = recovery ? &*recovery : nullptr;
  const Checkpoints checkpoints{&context_.keeper, resume_from};
  Result<JobResult> result = of_frames_
                                 ? render_frames(std::move(start), with, checkpoints)
                                 : render_picture(std::move(start), parent, with, checkpoints);
  if (!result.ok()) return result.error();
  result.value().stats.mixed_builds = mixed_builds_;
  return Rendered{std::move(result).value(), id};
}

Result<JobResult> JobRun::render_picture(StartingGuide start, const Parent& parent,
                                         const Recovery* recovery, const Checkpoints& checkpoints) {
  const std::shared_ptr<Film> film = running_->film();
  JobMoments moments(context_.stores.moments, id_, *film, [&](const GuideTable& guide) {
    return table_of(guide, scene_->hash, parent);
  });
  running_->on_pass(
      [&](const RenderProgress& progress, const RenderStats& stats, const Guide* guide) {
        last_pass_ = stats;
        if (context_.lease.holds()) moments.add(progress, stats, guide);
      });
  const std::unique_ptr<SharedPassSampler> shared = shared_sampler();
  Result<JobResult> result =
      context_.render(*scene_, settings_, std::move(start), *film, context_.pool, *running_,
                      context_.stop, context_.clock, recovery, checkpoints, shared.get());
  if (shared) log(shared->totals().text());
  running_->on_pass(nullptr);
  if (!moments.failure().empty()) warn(moments.failure());
  return result;
}

std::unique_ptr<SharedPassSampler> JobRun::shared_sampler() {
  const int workers = job_.request.given(field::kWorkers).value_or(1);
  if (workers == 1) return nullptr;
  if (!context_.stores.passes) {
    warn("workers: this server is alone and samples the whole picture");
    return nullptr;
  }
  Result<std::unique_ptr<SharedPassSampler>> made =
      SharedPassSampler::make({*context_.stores.passes, *scene_, settings_, context_.pool,
                               context_.clock, [this](const std::string& text) { warn(text); }},
                              {id_, job_.claim, workers, context_.shared_pass_seconds});
  if (made.ok()) return std::move(made).value();
  warn("workers: " + made.error().message);
  return nullptr;
}

Result<JobResult> JobRun::render_frames(StartingGuide start, const Recovery* recovery,
                                        const Checkpoints& checkpoints) {
  if (job_.request.given(field::kWorkers).value_or(1) != 1)
    warn("workers: a job of many frames is rendered by one worker");
  JobFrames frames({context_.stores.checkpoints, context_.stores.results, context_.stores.jobs,
                    *running_, context_.lease},
                   id_, frames_, /*goes_on=*/checkpoints.resume_from != nullptr, context_.stop);
  const auto scene_at = [&](double seconds) -> Result<std::shared_ptr<const PreparedScene>> {
    Result<std::shared_ptr<const PreparedScene>> scene = context_.stores.scenes.prepare_at(
        job_.request.get(field::kScene), seconds,
        [this](LoadStep, double) { return !context_.stop.stop_requested(); });
    if (!scene.ok()) return context_.stores.scenes.without_folder(scene.error());
    return lit_by_mix(scene.value(), settings_);
  };
  Result<JobResult> result =
      run_frames(*scene_, {job_.request, settings_, frames_, scene_at}, std::move(start), frames,
                 context_.pool, context_.stop, context_.clock, recovery, checkpoints);
  if (frames.last()) last_pass_ = frames.last();
  return result;
}

// The network that the job asks for. One that cannot be read is no reason to fail: the untrained
// one serves, and the job says so.
std::optional<Recovery> JobRun::recovery(const std::string& wanted) {
  if (wanted == "none") return {};
  const std::string name = network_name(context_.stores.weights, scene_->hash, wanted);
  Result<Network> network = load_network(context_.stores.weights, name);
  if (network.ok()) return Recovery{name, std::move(network).value()};
  warn("weights " + name + " were not used, but an untrained network: " + network.error().message);
  return Recovery{"untrained", included_network("untrained").value()};
}

Status JobRun::finish(Rendered rendered) {
  const double begin = context_.clock.seconds();
  const RenderStats& stats = rendered.result.stats;
  if (Status s = may_write(); !s.ok()) return s;
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
  if (const std::optional<LayeredPicture>& passes = rendered.result.passes)
    if (Status s = context_.stores.results.save_passes(id_, *passes); !s.ok()) return s;
  if (Status s = may_write(); !s.ok()) return s;
  if (!of_frames_)  // whose pictures are there
    if (Status s = context_.stores.results.save(id_, *running_->film(), rendered.result.metadata);
        !s.ok())
      return s;
  if (Status s = may_write(); !s.ok()) return s;
  context_.show(nullptr);  // who sees the job ended finds the finished picture, not the forming one
  const std::optional<TableFile>& table = rendered.result.table;
  const bool keep_table = table && job_.request.get(field::kTable) != "none";
  JobStore::Change change;
  if (keep_table) {
    Result<uint64_t> bytes = context_.stores.tables.write(*table);
    if (!bytes.ok()) return bytes.error();
    const TableHeader& header = table->header;
    change.events.push_back(
        {0, id_.text(), "table", proto::table_event(id_.text(), header.id, header.parents)});
    change.table = TableStore::row_of(
        *table,
        {header.id, job_.request.get(field::kScene), header.method, header.parents,
         context_.now_ms(), 0, stats.states, header.samples_seen, id_.text()},
        bytes.value());
  }
  change.edit = [&](JobRecord& job) {
    job.progress = {1, stats.samples_per_pixel, stats.seconds};
    job.table_in = rendered.table_in;
    if (keep_table) job.table_out = table->header.id;
    job.stats_json = stats_json(stats, /*indent=*/false);
    job.biased = !stats.unbiased || stats.recovery != "none";
    job.warnings = warnings_;
  };
  if (Status s = may_write(); !s.ok()) return s;
  context_.stores.checkpoints.finished(id_);  // before anyone can ask whether it is extendable
  const Status succeeded = move(JobState::kSucceeded, change);
  if (!succeeded.ok()) return succeeded;
  last_pass_ = stats;
  count(context_.clock.seconds() - begin);
  return succeeded;
}

Status JobRun::may_write() const {
  if (context_.lease.holds()) return {};
  return Error{ErrorCode::kCanceled, "another process may have the job by now", ""};
}

void JobRun::count(double finalizing_seconds) {
  Metrics* metrics = context_.stores.metrics;
  if (!metrics) return;
  if (last_pass_) metrics->add_job(*last_pass_, counted_, finalizing_seconds, warm_);
  metrics->add_end(to_string(job_.state));
}

void JobRun::keep_partial_picture() {
  if (!running_) return;
  const RunningJob::Shown shown = running_->shown();
  if (!shown.film || shown.film->version() == 0) return;
  const ImageMetadata metadata = {{"scene", job_.request.get(field::kScene)},
                                  {"method", settings_.method},
                                  {"seed", std::to_string(settings_.seed)},
                                  {"unfinished", "true"}};
  if (Status s = context_.stores.results.save({id_, shown.frame}, *shown.film, metadata); !s.ok()) {
    spdlog::error("job={} the picture is lost: {}", id_.text(), s.error().text());
  }
}

void JobRun::end(const Error& error) {
  const Result<JobRecord> now = context_.stores.jobs.get(id_);
  const auto is = [&](JobState state) { return now.ok() && now.value().state == state; };
  JobStore::Change change;
  JobState to = JobState::kFailed;
  if (is(JobState::kCanceling)) {
    to = JobState::kCanceled;
  } else if (is(JobState::kPausing) && error.code == ErrorCode::kCanceled) {
    to = JobState::kPaused;
  } else if (context_.stopping.stop_requested() &&
             (error.code == ErrorCode::kCanceled || error.code == ErrorCode::kIo)) {
    to = JobState::kQueued;  // kIo: a disk that did not take its end may do so at the next start
  } else if (context_.stores.shared && error.code == ErrorCode::kCanceled) {
    to = JobState::kQueued;  // the lease was over, as the database was away, and nobody took it up
  }
  if (to != JobState::kQueued && context_.lease.holds()) keep_partial_picture();
  context_.show(nullptr);
  change.claim = job_.claim;
  change.edit = [&](JobRecord& job) {
    if (running_) job.progress = running_->progress();
    job.warnings = warnings_;
    if (to == JobState::kFailed) job.error = proto::JobError{error.message, error.where};
    if (to == JobState::kQueued || to == JobState::kPaused)
      job.attempts = std::max(0, job.attempts - 1);  // an orderly stop is not the job's fault
  };
  for (;;) {
    Result<JobRecord> moved = context_.stores.jobs.move(id_, to, change);
    // It may have become canceling since the look above, or pausing.
    for (JobState other : {JobState::kPaused, JobState::kCanceled})
      if (!moved.ok() && moved.error().code == ErrorCode::kConflict)
        moved = context_.stores.jobs.move(id_, other, change);
    if (moved.ok()) {
      job_ = std::move(moved).value();
      if (!has_ended(job_.state)) return;
      context_.stores.checkpoints.remove(id_);
      return count(0);
    }
    // A disk that is full may have room again; at the next start the job is taken up anyway.
    if (moved.error().code != ErrorCode::kIo || !wait_for_disk(moved.error(), context_.stopping)) {
      spdlog::error("job={} its end is not recorded: {}", id_.text(), moved.error().text());
      return;
    }
  }
}

}  // namespace qray::server
