#include "server/policy/memory_budget.h"

#include <gtest/gtest.h>

#include <future>

namespace qray::server {
namespace {

using namespace std::chrono_literals;

// Runs take() on another thread; it has not ended while `before` is going on.
class Taker {
 public:
  Taker(MemoryBudget& budget, size_t bytes)
      : part_(std::async(std::launch::async, [&budget, bytes, stop = stop_.get_token()] {
          return budget.take(bytes, stop);
        })) {}
  bool waits() const { return part_.wait_for(50ms) == std::future_status::timeout; }
  MemoryBudget::Part get() { return part_.get(); }
  void stop() { stop_.request_stop(); }

 private:
  std::stop_source stop_;
  std::future<MemoryBudget::Part> part_;
};

TEST(MemoryBudget, WhatDoesNotFitWaitsForTheOthers) {
  MemoryBudget budget(100);
  std::optional<MemoryBudget::Part> first = budget.take(60, {});
  const MemoryBudget::Part second = budget.take(40, {});
  Taker third(budget, 30);
  EXPECT_TRUE(third.waits());
  first.reset();
  const MemoryBudget::Part got = third.get();
  const MemoryBudget::Part rest = budget.take(30, {});
}

TEST(MemoryBudget, WhoDoesNotWaitGetsWhatIsThereNow) {
  MemoryBudget budget(100);
  std::optional<MemoryBudget::Part> first = budget.take_now(60);
  EXPECT_TRUE(first);
  EXPECT_FALSE(budget.take_now(41));
  EXPECT_TRUE(budget.take_now(40));  // and gives it back
  first.reset();
  EXPECT_TRUE(budget.take_now(500));  // alone
}

TEST(MemoryBudget, WhatNeverFitsRunsAlone) {
  MemoryBudget budget(100);
  std::optional<MemoryBudget::Part> large = budget.take(500, {});
  Taker small(budget, 1);
  EXPECT_TRUE(small.waits());
  large.reset();
  std::optional<MemoryBudget::Part> got = small.get();
  Taker again(budget, 500);
  EXPECT_TRUE(again.waits());
  got.reset();
  again.get();
}

TEST(MemoryBudget, AStopEndsTheWait) {
  MemoryBudget budget(100);
  const MemoryBudget::Part all = budget.take(100, {});
  Taker waiting(budget, 1);
  EXPECT_TRUE(waiting.waits());
  waiting.stop();
  waiting.get();
  Taker next(budget, 1);  // the one that gave up took nothing and gave nothing back
  EXPECT_TRUE(next.waits());
  next.stop();
  next.get();
}

}  // namespace
}  // namespace qray::server
