// What the running job shows to the outside: its film, and how far it is. The render threads only
// store numbers here; a reader makes events and answers of them. Any thread.
#pragma once

#include <atomic>
#include <functional>
#include <memory>

#include "core/render/render_loop.h"
#include "server/model/job.h"

namespace qray::server {

class RunningJob final : public RenderObserver {
 public:
  RunningJob(JobId id, std::shared_ptr<Film> film) : id_(id), film_(std::move(film)) {}
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
  Film& film() const { return *film_; }
  std::shared_ptr<const Film> shared_film() const { return film_; }
  proto::JobProgress progress() const {
    return {fraction_.load(std::memory_order_relaxed), samples_.load(std::memory_order_relaxed),
            seconds_.load(std::memory_order_relaxed)};
  }
  // Something was rendered after learning had ended.
  bool past_learning() const { return past_learning_.load(std::memory_order_relaxed); }

 private:
  void store(const RenderProgress& p) {
    fraction_.store(p.fraction, std::memory_order_relaxed);
    samples_.store(p.samples_per_pixel, std::memory_order_relaxed);
    seconds_.store(p.seconds, std::memory_order_relaxed);
    if (!p.learning) past_learning_.store(true, std::memory_order_relaxed);
  }

  const JobId id_;
  const std::shared_ptr<Film> film_;
  std::function<void(const RenderProgress&, const RenderStats&, const Guide*)> on_pass_;
  std::atomic<double> fraction_{0}, seconds_{0};
  std::atomic<uint64_t> samples_{0};
  std::atomic<bool> past_learning_{false};
};

}  // namespace qray::server
