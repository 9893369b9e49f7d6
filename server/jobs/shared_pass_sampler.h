// The owner of a job whose passes several processes sample: it cuts each pass into units, samples
// some of them itself, and adds up in the order of the units whatever came back, whoever sampled
// it. So the picture and the table have the bits of one process. Passes that take less time than
// the others need to hear of them are sampled here alone; while the database is away all are.
//
// The first unit of each other process is sampled here too, before anything of it is added, and so
// is a unit of which two results differ: whose bits are others is put aside. One thread calls; a
// thread of its own samples.
#pragma once

#include <atomic>
#include <condition_variable>
#include <map>
#include <mutex>
#include <set>
#include <thread>
#include <tuple>

#include "core/base/clock.h"
#include "core/render/pass_sampler.h"
#include "core/render/renderer.h"
#include "server/jobs/unit_loop.h"

namespace qray::server {

class SharedPassSampler final : public PassSampler {
 public:
  struct Uses {
    SharedPasses& passes;
    const PreparedScene& scene;
    const RenderSettings& settings;
    TaskPool& pool;
    const Clock& clock;
    std::function<void(const std::string&)> warn;  // the job's readers
  };
  struct Wanted {
    JobId job;
    uint64_t claim = 0;
    int workers = 0;           // this one counted; 0: as many as there are
    double least_seconds = 0;  // a pass that takes less here is not shared
  };
  // kInvalid: the method's passes cannot be shared.
  static Result<std::unique_ptr<SharedPassSampler>> make(const Uses& uses, const Wanted& wanted);
  ~SharedPassSampler() override;

  // kCanceled: the job is not this process's any more, or should not be.
  Status sample(Renderer& renderer, const std::function<bool()>& enough,
                const std::stop_token& stop, RenderObserver& observer) override;

  // What it came to, for the log.
  struct Totals {
    int passes = 0;  // that were shared
    uint64_t units = 0, of_others = 0, bytes_of_others = 0, bytes_begun = 0;
    std::set<std::string> others;
    std::string text() const;
  };
  const Totals& totals() const { return totals_; }

 private:
  using Pass = SharedPasses::Pass;
  using Unit = SharedPasses::Unit;
  struct UnderWay {
    Pass pass;
    std::stop_source over;
  };
  SharedPassSampler(const Uses& uses, const Wanted& wanted, std::unique_ptr<UnitRenderer> renderer);

  void sample_alone(Renderer& renderer, const std::function<bool()>& enough,
                    const std::stop_token& stop, RenderObserver& observer);
  Status begin(const Renderer& renderer);
  SharedPasses::Cut cut_of(const Renderer& renderer, double pass_seconds) const;
  std::optional<Unit> next_ready(const Renderer& renderer, const std::stop_token& stop);
  Status collect();
  void arrived(Unit unit);
  void end_pass();
  // On its thread.
  void sample_own(const std::stop_token& stop);
  void sample_own(UnderWay& under_way);
  void check_units(UnderWay& under_way);
  void judge(const UnderWay& under_way, const Unit& unit, const std::string& hash);
  bool is_bad(const std::string& worker);
  void tell_of_others();
  void trust(const std::string& worker);
  std::vector<size_t> drop(const std::string& worker);

  const Uses uses_;
  const Wanted wanted_;
  const std::string bits_;
  const std::unique_ptr<UnitRenderer> renderer_;
  UnitLoop loop_;
  int64_t serial_ = 0;           // of the passes that were begun
  int shared_ = -1;              // Renderer::pass() of the one under way; -1: none is
  std::string guide_;            // SHA-256 of what was handed out
  double seconds_a_sample_ = 0;  // of this process, by its last pass; 0: not known
  double looked_ = 0;            // at the database, the last time
  double came_ = 0;              // seconds: when the last unit did, or the pass began
  Totals totals_;

  std::atomic<bool> nothing_to_take_{false};  // for its thread

  std::mutex mutex_;  // guards what follows
  std::condition_variable_any changed_;
  std::shared_ptr<UnderWay> under_way_;  // null: no pass is
  bool own_is_busy_ = false;             // its thread has the pass
  std::map<size_t, Unit> ready_;         // by unit: to be added
  struct Origin {
    std::string worker, hash;
  };
  std::map<size_t, Origin> known_;  // units that arrived
  std::vector<Unit> to_check_;
  std::map<std::string, std::vector<Unit>> held_;  // of those whose first unit is to be checked
  std::set<std::tuple<int64_t, size_t, std::string>> checked_;  // disputes: pass, unit, worker
  std::set<std::string> trusted_, bad_;
  double own_seconds_ = 0, own_samples_ = 0;  // of the pass
  std::jthread own_thread_;                   // last: it uses the others
};

}  // namespace qray::server
