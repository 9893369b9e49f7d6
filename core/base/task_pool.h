// A fixed set of worker threads that run one parallel loop at a time. Indices are handed out in
// order, one by one, so an ordered reduction keeps few results waiting. `run` may be called by one
// thread at a time; the body may be called by any worker, each with its own worker number.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace qray {

class TaskPool {
 public:
  using Body = std::function<void(size_t index, int worker)>;

  explicit TaskPool(int threads);  // at least 1
  ~TaskPool();
  TaskPool(const TaskPool&) = delete;
  TaskPool& operator=(const TaskPool&) = delete;

  int threads() const { return static_cast<int>(workers_.size()); }
  // Calls body(i, worker) for i in [0, count); returns when all are done. The body must not throw.
  void run(size_t count, const Body& body);

 private:
  void work(int worker);

  std::mutex mutex_;
  std::condition_variable wake_, done_;
  const Body* body_ = nullptr;
  size_t next_ = 0, count_ = 0, active_ = 0;
  bool stopping_ = false;
  std::vector<std::thread> workers_;
};

}  // namespace qray
