#include "core/base/task_pool.h"

#include "core/base/check.h"

namespace qray {

TaskPool::TaskPool(int threads) {
  QRAY_CHECK(threads >= 1);
  for (int i = 0; i < threads; ++i) workers_.emplace_back([this, i] { work(i); });
}

TaskPool::~TaskPool() {
  {
    std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  for (std::thread& t : workers_) t.join();
}

void TaskPool::run(size_t count, const Body& body) {
  std::unique_lock lock(mutex_);
  QRAY_CHECK(body_ == nullptr);
  body_ = &body;
  next_ = 0;
  count_ = count;
  wake_.notify_all();
  done_.wait(lock, [&] { return next_ >= count_ && active_ == 0; });
  body_ = nullptr;
}

void TaskPool::work(int worker) {
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [&] { return stopping_ || (body_ != nullptr && next_ < count_); });
    if (stopping_) return;
    const size_t index = next_++;
    const Body& body = *body_;
    ++active_;
    lock.unlock();
    body(index, worker);
    lock.lock();
    if (--active_ == 0 && next_ >= count_) done_.notify_all();
  }
}

}  // namespace qray
