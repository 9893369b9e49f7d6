// Calls each function that scheduler.cpp replaces, so that the real one is looked up once and not
// in each life.
#pragma once

#include <sys/syscall.h>
#include <unistd.h>

#include <condition_variable>
#include <mutex>
#include <thread>

namespace qray::server::test {

inline void look_functions_up() {
  std::mutex mutex;
  std::condition_variable changed;
  bool ready = false;
  std::unique_lock lock(mutex);
  std::thread other([&] {
    const std::lock_guard guard(mutex);
    ready = true;
    changed.notify_one();
    changed.notify_all();
  });
  changed.wait(lock, [&] { return ready; });
  lock.unlock();
  other.join();
  (void)::syscall(SYS_getpid);
}

}  // namespace qray::server::test
