#include "core/base/task_pool.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

#include "core/base/check.h"

namespace qray {

struct TaskPool::Share {
  explicit Share(double w) : weight(w) {}
  bool has_work() const { return next < count; }

  const double weight;
  double used = 0;  // seconds of threads over the weight, about
  const Body* body = nullptr;
  const std::function<bool()>* enough = nullptr;  // may be null
  size_t next = 0, count = 0, active = 0;
  std::condition_variable done;
};

class TaskPool::Threads {
 public:
  explicit Threads(int count) {
    QRAY_CHECK(count >= 1);
    for (int i = 0; i < count; ++i) workers_.emplace_back([this, i] { work(i); });
  }
  ~Threads() {
    {
      std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    wake_.notify_all();
    for (std::thread& t : workers_) t.join();
  }
  int count() const { return static_cast<int>(workers_.size()); }

  size_t run(Share& share, size_t count, const Body& body, const std::function<bool()>* enough) {
    std::unique_lock lock(mutex_);
    QRAY_CHECK(share.body == nullptr);
    share.used = std::max(share.used, served_);  // no claim on time that it did not want
    share.body = &body;
    share.enough = enough;
    share.next = 0;
    share.count = count;
    running_.push_back(&share);
    wake_.notify_all();
    share.done.wait(lock, [&] { return !share.has_work() && share.active == 0; });
    std::erase(running_, &share);
    share.body = nullptr;
    return share.next;
  }

 private:
  // The share to work for, whose loop goes on; null: none has work.
  Share* next_share() {
    Share* best = nullptr;
    for (Share* share : running_) {
      if (share->has_work() && share->enough && (*share->enough)()) {
        share->count = share->next;
        if (share->active == 0) share->done.notify_all();
      }
      if (share->has_work() && (!best || share->used < best->used)) best = share;
    }
    return best;
  }

  void work(int worker) {
    std::unique_lock lock(mutex_);
    for (;;) {
      Share* share = nullptr;
      wake_.wait(lock, [&] { return stopping_ || (share = next_share()) != nullptr; });
      if (stopping_) return;
      served_ = share->used;
      const size_t index = share->next++;
      const Body& body = *share->body;
      ++share->active;
      lock.unlock();
      const auto start = std::chrono::steady_clock::now();
      body(index, worker);
      const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
      lock.lock();
      share->used += took.count() / share->weight;
      if (--share->active == 0 && !share->has_work()) share->done.notify_all();
    }
  }

  std::mutex mutex_;
  std::condition_variable wake_;
  std::vector<Share*> running_;
  double served_ = 0;  // Share::used of who was served last: the least, then
  bool stopping_ = false;
  std::vector<std::thread> workers_;
};

TaskPool::TaskPool(int threads)
    : threads_(std::make_shared<Threads>(threads)), share_(std::make_unique<Share>(1)) {}

TaskPool::TaskPool(const TaskPool& other, double weight)
    : threads_(other.threads_), share_(std::make_unique<Share>(weight)) {
  QRAY_CHECK(weight > 0);
}

TaskPool::~TaskPool() = default;

int TaskPool::threads() const { return threads_->count(); }

void TaskPool::run(size_t count, const Body& body) { threads_->run(*share_, count, body, nullptr); }

size_t TaskPool::run_until(size_t count, const Body& body, const std::function<bool()>& enough) {
  return threads_->run(*share_, count, body, &enough);
}

}  // namespace qray
