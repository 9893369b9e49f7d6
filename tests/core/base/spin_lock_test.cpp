#include "core/base/spin_lock.h"

#include <gtest/gtest.h>

#include <mutex>
#include <thread>
#include <vector>

namespace qray {
namespace {

TEST(SpinLock, OnlyOneAtATime) {
  constexpr int kThreads = 4, kTurns = 20000;
  SpinLock lock;
  int64_t sum = 0, inside = 0;
  bool alone = true;
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t)
    threads.emplace_back([&] {
      for (int i = 0; i < kTurns; ++i) {
        const std::lock_guard guard(lock);
        alone = alone && ++inside == 1;
        ++sum;
        --inside;
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_TRUE(alone);
  EXPECT_EQ(sum, int64_t{kThreads} * kTurns);
}

TEST(SpinLock, ACopyIsFree) {
  SpinLock lock;
  lock.lock();
  SpinLock copy(lock);
  copy.lock();  // does not wait for ever
  copy.unlock();
  lock.unlock();
}

}  // namespace
}  // namespace qray
