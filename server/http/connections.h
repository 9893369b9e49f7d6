// The open connections, a thread each, and never more than a bound: when it is reached, the
// connection that has waited longest for its next request makes room; when none does, of those that
// wait for their client in the middle of one, the one whose request is oldest. Any thread.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>

namespace qray::server {

class Connections {
 public:
  explicit Connections(size_t max) : max_(max) {}
  ~Connections() { stop(); }
  Connections(const Connections&) = delete;
  Connections& operator=(const Connections&) = delete;

  // Runs body(id) on a thread of its own, then closes fd. Waits, at most a second, when all
  // connections are busy; false: fd was closed instead.
  bool start(int fd, std::function<void(uint64_t id)> body);
  // Between requests a connection is idle, and may be closed to make room.
  void set_idle(uint64_t id, bool idle);
  // In the middle of a request: the client sends nothing, or takes nothing.
  void set_stalled(uint64_t id, bool stalled);
  // Shuts every connection down and waits for the threads.
  void stop();
  bool stopping() const;
  size_t count() const;

 private:
  struct Entry {
    int fd = -1;
    bool idle = true, stalled = false;
    std::chrono::steady_clock::time_point since;  // idle, or serving this request
    bool evicted = false;
  };
  void evict_one();  // with the mutex held

  const size_t max_;
  mutable std::mutex mutex_;
  std::condition_variable ended_;
  std::map<uint64_t, Entry> open_;
  uint64_t next_id_ = 1;
  bool stopping_ = false;
};

}  // namespace qray::server
