// The sessions that are open: few, as each renders all the time. Any thread.
#pragma once

#include <map>
#include <semaphore>

#include "server/jobs/job_runner.h"
#include "server/live/live_session.h"

namespace qray::server {

class LiveSessions {
 public:
  static constexpr int64_t kMaxPixels = 2048LL * 2048;
  struct Limits {
    size_t at_once = 4;
    double idle_seconds = 300;
  };
  LiveSessions(Stores stores, const TaskPool& threads, MemoryBudget& memory, const Limits& limits,
               const Clock& clock, std::function<int64_t()> now_ms)
      : stores_(stores),
        threads_(threads),
        memory_(memory),
        limits_(limits),
        clock_(clock),
        now_ms_(std::move(now_ms)) {}
  ~LiveSessions() { stop(); }

  // Loads the scene, which may take long. kBusy: there are as many as may be, there is no memory
  // beside the jobs that run, or the server stops.
  Result<std::shared_ptr<LiveSession>> open(const proto::LiveRequest& request);
  std::shared_ptr<LiveSession> find(const std::string& id);  // null: there is none
  // Ends all, and waits until they have left what they learned.
  void stop();
  size_t count();

 private:
  void forget_ended();  // the mutex is held
  Result<LiveSession::Start> prepare(const proto::LiveRequest& request);
  Status choose_table(const std::string& wanted, LiveSession::Start& start);
  void keep(const proto::LiveRequest& request, const TableFile& table, const GuideStats& stats);

  Stores stores_;
  const TaskPool& threads_;
  MemoryBudget& memory_;
  const Limits limits_;
  const Clock& clock_;
  std::function<int64_t()> now_ms_;
  std::mutex mutex_;  // guards what follows
  std::map<std::string, std::shared_ptr<LiveSession>> sessions_;
  size_t opening_ = 0;
  uint64_t opened_ = 0;
  bool stopped_ = false;
};

}  // namespace qray::server
