// One walk through a scene: a thread that renders frame after frame for whoever reads them, with a
// share of the render threads. Without readers it soon ends, and leaves what it learned as a table.
// Any thread.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

#include "core/job/run_job.h"
#include "core/live/live_view.h"
#include "proto/live_messages.h"
#include "server/policy/memory_budget.h"

namespace qray::server {

struct ShownFrame {
  LiveFrame frame;
  uint64_t camera = 0;  // the number of the camera that it shows
};

class LiveSession {
 public:
  struct Start {
    std::string id;
    proto::LiveRequest request;
    std::string recover;  // what the network is
    std::shared_ptr<const PreparedScene> scene;
    LiveSettings settings;
    std::unique_ptr<Guide> guide;
    std::optional<TableHeader> table;
    Network network;
    MemoryBudget::Part memory;  // given back when it ends
    double idle_seconds = 300;  // without a call, then it ends
    int readers = 4;
    std::function<void(const LiveFrame&)> made;  // called with each frame
    // What it learned, when it ends; not called where it learned nothing.
    std::function<void(const TableFile&, const GuideStats&)> leave;
  };
  LiveSession(Start start, const TaskPool& threads, const Clock& clock);
  ~LiveSession();
  LiveSession(const LiveSession&) = delete;
  LiveSession& operator=(const LiveSession&) = delete;

  const std::string& id() const { return start_.id; }
  proto::LiveInfo info() const;
  // kInvalid: no camera. One older than the newest known changes nothing.
  Result<proto::LiveCameraAnswer> set_camera(const proto::LiveCameraRequest& request);
  void set_switches(const proto::LiveSwitchesRequest& switches);
  void set_lights(std::vector<double> factors);

  // Ends soon after the last reader has left. False: too many, or it has ended.
  bool add_reader();
  void remove_reader();
  // The newest frame if it is newer than number `after`; waits for one. Null: there is none yet.
  std::shared_ptr<const ShownFrame> wait(uint64_t after, std::chrono::milliseconds patience) const;
  void end();
  bool ended() const;  // and its memory is free

 private:
  struct Wanted {
    Camera camera;
    uint64_t number = 0;
    proto::LiveSwitchesRequest switches;
    std::vector<double> factors;
  };
  void run(std::stop_token stop);
  void frames(std::stop_token stop);
  bool wait_for_reader(std::stop_token stop);
  bool relight(const std::vector<double>& factors);
  void leave_table();

  Start start_;
  TaskPool pool_;
  const Clock& clock_;
  const Camera scene_camera_;
  const std::vector<std::string> lights_;
  std::unique_ptr<LiveView> view_;  // the thread's

  mutable std::mutex mutex_;  // guards what follows
  mutable std::condition_variable changed_;
  Wanted wanted_;
  std::shared_ptr<const ShownFrame> newest_;
  int readers_ = 0;
  double reader_left_ = 0, last_call_ = 0;  // clock's seconds
  bool had_reader_ = false, ended_ = false;
  std::jthread thread_;
};

}  // namespace qray::server
