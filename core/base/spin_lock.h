// A lock for a few instructions, in one byte beside what it guards; std::lock_guard holds it.
#pragma once

#include <atomic>
#include <thread>

namespace qray {

class SpinLock {
 public:
  SpinLock() = default;
  SpinLock(const SpinLock&) {}  // the copy of what it guards is nobody's yet
  SpinLock& operator=(const SpinLock&) { return *this; }

  void lock() {
    while (held_.exchange(true, std::memory_order_acquire))
      while (held_.load(std::memory_order_relaxed)) std::this_thread::yield();
  }
  void unlock() { held_.store(false, std::memory_order_release); }

 private:
  std::atomic<bool> held_ = false;
};

}  // namespace qray
