// Worker threads for parallel loops. Several loops at once share them: a worker that is free takes
// from the loop that had the least time for its weight, so none starves. Each TaskPool is one
// loop's share; `run` may be called by one thread at a time for each. Indices are handed out in
// order, one by one, so an ordered reduction keeps few results waiting. The body may be called by
// any worker, each with its own worker number.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace qray {

class TaskPool {
 public:
  using Body = std::function<void(size_t index, int worker)>;

  explicit TaskPool(int threads);  // at least 1; a share of weight 1
  // Another share of the same threads, which live as long as any share does.
  TaskPool(const TaskPool& other, double weight);
  ~TaskPool();
  TaskPool(const TaskPool&) = delete;
  TaskPool& operator=(const TaskPool&) = delete;

  int threads() const;
  // Calls body(i, worker) for i in [0, count); returns when all are done. The body must not throw.
  void run(size_t count, const Body& body);
  // The same, but hands out no more when `enough` says so (asked before each, one thread at a
  // time; must return at once). Returns how many were done: [0, that).
  size_t run_until(size_t count, const Body& body, const std::function<bool()>& enough);

 private:
  class Threads;
  struct Share;
  std::shared_ptr<Threads> threads_;
  std::unique_ptr<Share> share_;
};

}  // namespace qray
