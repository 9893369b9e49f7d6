#include "core/job/run_frames.h"

#include <algorithm>
#include <utility>

namespace qray {
namespace {

constexpr int kFade = 4;  // docs/frames.md has what it is worth

bool moves(const PreparedScene& scene, const FramesJob& job) {
  return scene.scene.moves_surfaces && job.frames.front().seconds;
}

// What moves, moves little from one frame to the next, and the table with it.
std::vector<int> order_of(const PreparedScene& scene, const FramesJob& job) {
  std::vector<int> order = spread_order(static_cast<int>(job.frames.size()));
  if (moves(scene, job)) std::ranges::sort(order);
  return order;
}

class FramesRun {
 public:
  FramesRun(const PreparedScene& scene, const FramesJob& job, StartingGuide start,
            FrameKeeper& frames, TaskPool& pool, std::stop_token stop, const Clock& clock,
            const Recovery* recovery, Checkpointer* keeper)
      : scene_(scene),
        job_(job),
        start_(std::move(start)),
        guide_(start_.guide.get()),
        frames_(frames),
        pool_(pool),
        stop_(std::move(stop)),
        clock_(clock),
        recovery_(recovery),
        keeper_(keeper),
        order_(order_of(scene, job)) {
    at_.frames.resize(order_.size());
    at_.turns.resize(order_.size());
  }

  Result<JobResult> run(SnapshotReader* resume_from) {
    if (resume_from && !resume(*resume_from)) return corrupt();
    // In a turn that was cut off its frame's state follows, and then the guide's.
    SnapshotReader* turn_from = resume_from && at_.in_turn ? resume_from : nullptr;
    for (; at_.next < order_.size(); ++at_.next)
      if (Status s = turn(order_[at_.next], std::exchange(turn_from, nullptr)); !s.ok())
        return s.error();
    for (std::optional<size_t> again; (again = wanted_again());) {
      at_.next = *again;
      if (Status s = turn(order_[at_.next], nullptr); !s.ok()) return s.error();
      at_.next = order_.size();
    }
    if (keeper_) (void)keeper_->save([this](SnapshotWriter& out) { save_between(out); });
    return result();
  }

 private:
  // Where the job is.
  struct Place {
    uint64_t next = 0;     // in the order: whose turn it is
    bool in_turn = false;  // it has begun
    std::vector<FrameProgress> frames;
    std::vector<int> turns;  // whole ones that each has had
    template <class Self, class Archive>
    static void exchange(Self& self, Archive& archive) {
      archive(self.next, self.in_turn, self.frames, self.turns);
    }
  };

  static Error corrupt() {
    return {ErrorCode::kCorrupt, "not a state of this job's frames", "checkpoint"};
  }
  FrameProgress& progress(int frame) { return at_.frames[static_cast<size_t>(frame)]; }
  int& turns(int frame) { return at_.turns[static_cast<size_t>(frame)]; }

  bool resume(SnapshotReader& in) {
    in(at_);
    const bool fits = in.ok() && at_.frames.size() == order_.size() &&
                      at_.turns.size() == order_.size() && at_.next <= order_.size() &&
                      (!at_.in_turn || at_.next < order_.size());
    if (!fits) return false;
    if (at_.in_turn) return true;
    if (guide_) guide_->load_state(in);
    if (!in.whole()) return false;
    at_.next = 0;  // more is asked of it
    return true;
  }

  void save_between(SnapshotWriter& out) {
    at_.in_turn = false;
    out(at_);
    if (guide_) guide_->save_state(out);
  }

  // A frame that was left out when its turn came.
  std::optional<size_t> wanted_again() const {
    for (size_t i = 0; i < order_.size(); ++i)
      if (at_.turns[static_cast<size_t>(order_[i])] == 0 && frames_.wanted(order_[i])) return i;
    return {};
  }

  // The job's keeper, which ends a turn between two tiles once its frame is not wanted any more.
  class TurnKeeper final : public Checkpointer {
   public:
    TurnKeeper(Checkpointer* keeper, FrameKeeper& frames, int frame)
        : keeper_(keeper), frames_(frames), frame_(frame) {}
    bool due() override { return !frames_.wanted(frame_) || (keeper_ && keeper_->due()); }
    bool save(const std::function<void(SnapshotWriter&)>& write) override {
      left_out_ = !frames_.wanted(frame_);
      return !left_out_ && keeper_ && keeper_->save(write);
    }
    bool left_out() const { return left_out_; }

   private:
    Checkpointer* keeper_;
    FrameKeeper& frames_;
    const int frame_;
    bool left_out_ = false;
  };

  Status turn(int frame, SnapshotReader* from) {
    if (!from && !frames_.wanted(frame)) return frames_.left_out(frame, nullptr);
    if (Status s = enter(frame); !s.ok()) return s;
    const RenderSettings settings = frame_settings(job_.request, job_.settings, job_.frames, frame);
    const auto film = std::make_shared<Film>(settings.width, settings.height,
                                             film_layers(scene().scene, settings));
    RenderMode mode;
    mode.view_lasts = order_.size() == 1;
    Renderer renderer(scene(), settings, guide_, *film, pool_, clock_, mode);
    if (Status s = begin(renderer, settings, frame, from); !s.ok()) return s;
    RenderObserver& observer = frames_.begin_turn(frame, film);
    const WriteState write = [&](SnapshotWriter& out) {
      at_.in_turn = true;
      out(at_);
      renderer.save_state(out);
      if (guide_) guide_->save_state(out);
    };
    TurnKeeper keeper(keeper_, frames_, frame);
    if (Status s = step_render(renderer, guide_, observer, stop_, &keeper, write); !s.ok())
      return keeper.left_out() ? frames_.left_out(frame, film.get()) : s;
    return end(renderer, settings, frame, *film);
  }

  // The scene as the frame shows it.
  const PreparedScene& scene() const { return moved_ ? *moved_ : scene_; }

  // Null: as at rest.
  Result<std::shared_ptr<const PreparedScene>> moved_to(size_t frame) const {
    if (!moves(scene_, job_)) return std::shared_ptr<const PreparedScene>();
    return job_.scene_at(*job_.frames[frame].seconds);
  }

  // Of where something stood before, what was learned is soon outweighed; of lights that are
  // others, nothing is known.
  Status enter(int frame) {
    moved_.reset();
    Result<std::shared_ptr<const PreparedScene>> moved = moved_to(static_cast<size_t>(frame));
    if (!moved.ok()) return moved.error();
    moved_ = std::move(moved).value();
    if (!moved_ || !guide_) return {};
    if (at_.next > 0) guide_->fade(kFade);
    guide_->set_lights(moved_->guide_setup(job_.settings).lights);
    return {};
  }

  Status begin(Renderer& renderer, const RenderSettings& settings, int frame,
               SnapshotReader* from) {
    if (from) {
      const bool fits = renderer.load_state(*from);
      if (fits && guide_) guide_->load_state(*from);
      return fits && from->whole() ? Status() : Status(corrupt());
    }
    if (const int turn = turns(frame); turn > 0)
      return frames_.load(frame, turn, [&](SnapshotReader& in) {
        int kept = 0;
        in(kept);
        return kept == turn && renderer.load_state(in) && in.whole();
      });
    if (const auto pilot = render_pilot(scene(), settings, guide_, pool_, clock_, stop_))
      renderer.begin_after(*pilot);
    return {};
  }

  Status end(Renderer& renderer, const RenderSettings& settings, int frame, const Film& film) {
    JobResult result;
    result.stats = renderer.stats();
    FrameProgress& now = progress(frame);
    now.samples = result.stats.samples_per_pixel;
    now.learning_samples = result.stats.learning_samples_per_pixel;
    now.seconds = result.stats.seconds;
    now.noise = result.stats.noise;
    now.paths = result.stats.paths;
    now.rays = result.stats.rays;
    now.dropped_samples = result.stats.dropped_samples;
    if (recovery_) {
      if (Status s =
              recover_result(scene(), settings, *recovery_, film, pool_, stop_, clock_, result);
          !s.ok())
        return s;
      recovery_seconds_ += result.stats.recovery_seconds;
    }
    result.metadata = metadata(result.stats, frame);
    if (result.recovered) {
      result.recovered_metadata = result.metadata;
      result.recovered_metadata["recovery"] = recovery_->name;
      result.recovered_metadata["unbiased"] = "false";
    }
    const Result<NeighbourScenes> beside = neighbour_scenes(frame, settings);
    if (!beside.ok()) return beside.error();
    if (Status s = add_passes(scene(), settings, film, neighbours(frame, beside.value()), pool_,
                              stop_, clock_, result);
        !s.ok())
      return s;
    passes_seconds_ += result.stats.picture_passes_seconds;
    const int turn = turns(frame) + 1;
    if (Status s = frames_.save(frame, turn,
                                [&](SnapshotWriter& out) {
                                  out(turn);
                                  renderer.save_state(out);
                                });
        !s.ok())
      return s;
    turns(frame) = turn;
    last_ = result.stats;
    return frames_.end_turn(frame, now, film, result);
  }

  // As the scene is in the frames beside this one; null: as in all.
  struct NeighbourScenes {
    std::shared_ptr<const PreparedScene> before, after;
  };
  Result<NeighbourScenes> neighbour_scenes(int frame, const RenderSettings& settings) const {
    NeighbourScenes out;
    if (!settings.picture_passes.has(PicturePass::kMotion)) return out;
    const auto at = static_cast<size_t>(frame);
    if (at > 0) {
      Result<std::shared_ptr<const PreparedScene>> before = moved_to(at - 1);
      if (!before.ok()) return before.error();
      out.before = std::move(before).value();
    }
    if (at + 1 < job_.frames.size()) {
      Result<std::shared_ptr<const PreparedScene>> after = moved_to(at + 1);
      if (!after.ok()) return after.error();
      out.after = std::move(after).value();
    }
    return out;
  }
  NeighbourFrames neighbours(int frame, const NeighbourScenes& scenes) const {
    const auto at = static_cast<size_t>(frame);
    NeighbourFrames out;
    if (at > 0) out.before = {&job_.frames[at - 1].camera, scenes.before.get()};
    if (at + 1 < job_.frames.size()) out.after = {&job_.frames[at + 1].camera, scenes.after.get()};
    return out;
  }

  ImageMetadata metadata(const RenderStats& stats, int frame) const {
    ImageMetadata m = picture_metadata(stats, scene_, start_.table, nullptr);
    m["frame"] = std::to_string(frame);
    if (const std::string& name = job_.frames[static_cast<size_t>(frame)].name; !name.empty())
      m["camera"] = name;
    if (const auto seconds = job_.frames[static_cast<size_t>(frame)].seconds)
      m["seconds_of_animation"] = std::to_string(*seconds);
    return m;
  }

  // Times and counts of all frames; the rest as of the last one.
  Result<JobResult> result() {
    JobResult out;
    RenderStats& all = out.stats;
    all = last_;
    all.frames = static_cast<int>(at_.frames.size());
    all.seed = job_.settings.seed;
    all.passes.clear();
    all.last_pass_tiles = all.pilot_samples = 0;
    all.guide_passes.clear();
    all.recovery_seconds = recovery_seconds_;
    all.picture_passes_seconds = passes_seconds_;
    all.seconds = all.noise = 0;
    all.samples_per_pixel = all.learning_samples_per_pixel = 0;
    all.paths = all.rays = all.dropped_samples = 0;
    for (const FrameProgress& frame : at_.frames) {
      all.seconds += frame.seconds;
      all.noise = std::max(all.noise, frame.noise);
      all.samples_per_pixel = std::max(all.samples_per_pixel, frame.samples);
      all.learning_samples_per_pixel =
          std::max(all.learning_samples_per_pixel, frame.learning_samples);
      all.paths += frame.paths;
      all.rays += frame.rays;
      all.dropped_samples += frame.dropped_samples;
    }
    if (guide_) out.table = table_of(*guide_, scene_.hash, start_.table);
    out.metadata =
        picture_metadata(all, scene_, start_.table, out.table ? &out.table->header : nullptr);
    return out;
  }

  const PreparedScene& scene_;                  // at rest
  std::shared_ptr<const PreparedScene> moved_;  // at the frame's time; null: as at rest
  const FramesJob& job_;
  StartingGuide start_;
  Guide* guide_;
  FrameKeeper& frames_;
  TaskPool& pool_;
  const std::stop_token stop_;
  const Clock& clock_;
  const Recovery* recovery_;
  Checkpointer* keeper_;
  const std::vector<int> order_;
  Place at_;
  RenderStats last_;
  double recovery_seconds_ = 0, passes_seconds_ = 0;
};

}  // namespace

Result<JobResult> run_frames(const PreparedScene& scene, const FramesJob& job, StartingGuide start,
                             FrameKeeper& frames, TaskPool& pool, std::stop_token stop,
                             const Clock& clock, const Recovery* recovery,
                             const Checkpoints& checkpoints) {
  if (recovery)
    if (Status s = check_recovery(*recovery, job.settings); !s.ok()) return s.error();
  RenderSettings settings = job.settings;
  settings.estimates_noise |= recovery != nullptr || passes_need_noise(settings);
  const FramesJob whole{job.request, settings, job.frames, job.scene_at};
  return FramesRun(scene, whole, std::move(start), frames, pool, std::move(stop), clock, recovery,
                   checkpoints.keeper)
      .run(checkpoints.resume_from);
}

}  // namespace qray
