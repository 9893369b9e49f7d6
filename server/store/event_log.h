// The recent events in memory, for readers that come and go: a ring with a wait. A reader that fell
// behind the ring is told to start anew; nobody ever waits for a reader. Any thread.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string>
#include <vector>

namespace qray::server {

struct Event {
  uint64_t id = 0;  // rising; 0: not given yet
  std::string job;
  std::string kind;  // state, loading, progress, table, done, deleted
  std::string data;  // JSON on one line
};

class EventLog {
 public:
  explicit EventLog(size_t capacity = 4096) : capacity_(capacity) {}

  // After a restart: what is still known of the time before, ids up to `lost_up_to` being lost; no
  // id up to `newest` will come again.
  void restore(uint64_t lost_up_to, std::vector<Event> events, uint64_t newest);
  void publish(Event event);  // ids must rise
  // Ends all waits, for good.
  void close();

  struct Batch {
    bool reset = false;   // events after the cursor are lost; or the cursor is not one of ours
    uint64_t cursor = 0;  // to ask with next time
    std::vector<Event> events;
  };
  // Events after `cursor` (of one job, unless `job` is empty); waits for one at most `timeout`.
  Batch wait(uint64_t cursor, const std::string& job, std::chrono::milliseconds timeout) const;
  uint64_t newest() const;
  bool closed() const;

 private:
  const size_t capacity_;
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::deque<Event> ring_;
  uint64_t newest_ = 0;
  uint64_t lost_ = 0;  // the newest event that left the ring
  bool closed_ = false;
};

}  // namespace qray::server
