// What the running job shows to the outside: the film of the frame under way, and how far it is.
// The render threads only store numbers here; a reader makes events and answers of them. Any
// thread.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>

#include "core/render/render_loop.h"
#include "server/model/job.h"

namespace qray::server {

class RunningJob final : public RenderObserver {
 public:
  explicit RunningJob(JobId id, std::vector<std::string> light_groups = {})
      : id_(id), light_groups_(std::move(light_groups)) {}
  // The frame under way from now on; a plain job's is the first. `others`: what the job's other
  // frames add to its progress, as the share of all and in seconds.
  struct Others {
    double fraction = 0, share = 1, seconds = 0;  // of this frame the share counts
  };
  void show(int frame, std::shared_ptr<Film> film, const Others& others) {
    others_ = others;
    std::lock_guard lock(mutex_);
    frame_ = frame;
    film_ = std::move(film);
    ++films_;
  }
  // Is told of each pass on the thread that renders; from before the render until it has ended.
  void on_pass(std::function<void(const RenderProgress&, const RenderStats&, const Guide*)> call) {
    on_pass_ = std::move(call);
  }

  void on_tile(const RenderProgress& p) override { store(p); }
  void on_pass(const RenderProgress& p, const RenderStats& stats, const Guide* guide) override {
    store(p);
    if (on_pass_) on_pass_(p, stats, guide);
  }

  JobId id() const { return id_; }
  const std::vector<std::string>& light_groups() const { return light_groups_; }
  // Null: that frame is not under way.
  std::shared_ptr<Film> film(int frame = 0) const {
    std::lock_guard lock(mutex_);
    return frame == frame_ ? film_ : nullptr;
  }
  struct Shown {
    int frame = 0;
    std::shared_ptr<const Film> film;  // null: none yet
    uint64_t films = 0;                // that were shown, this one counted
  };
  Shown shown() const {
    std::lock_guard lock(mutex_);
    return {frame_, film_, films_};
  }
  proto::JobProgress progress() const {
    return {fraction_.load(std::memory_order_relaxed), samples_.load(std::memory_order_relaxed),
            seconds_.load(std::memory_order_relaxed)};
  }
  double frame_seconds() const { return frame_seconds_.load(std::memory_order_relaxed); }
  // Something was rendered after learning had ended.
  bool past_learning() const { return past_learning_.load(std::memory_order_relaxed); }

 private:
  void store(const RenderProgress& p) {
    fraction_.store(others_.fraction + others_.share * p.fraction, std::memory_order_relaxed);
    samples_.store(p.samples_per_pixel, std::memory_order_relaxed);
    seconds_.store(others_.seconds + p.seconds, std::memory_order_relaxed);
    frame_seconds_.store(p.seconds, std::memory_order_relaxed);
    if (!p.learning) past_learning_.store(true, std::memory_order_relaxed);
  }

  const JobId id_;
  const std::vector<std::string> light_groups_;
  Others others_;  // the render threads' alone
  std::function<void(const RenderProgress&, const RenderStats&, const Guide*)> on_pass_;
  mutable std::mutex mutex_;
  int frame_ = 0;
  std::shared_ptr<Film> film_;
  uint64_t films_ = 0;
  std::atomic<double> fraction_{0}, seconds_{0}, frame_seconds_{0};
  std::atomic<uint64_t> samples_{0};
  std::atomic<bool> past_learning_{false};
};

}  // namespace qray::server
