#include "server/jobs/gather.h"

#include <gtest/gtest.h>

#include <atomic>
#include <latch>
#include <stdexcept>
#include <thread>

namespace qray::server {
namespace {

TEST(Gather, EachGetsItsAnswerOnce) {
  constexpr int kThreads = 8, kEach = 300;
  int working = 0, answered = 0;  // by one thread at a time: no lock of their own
  Gather<int, int> gather([&](std::span<const int> in) {
    EXPECT_EQ(++working, 1);
    std::vector<int> out;
    for (int v : in) out.push_back(10 * v);
    answered += static_cast<int>(in.size());
    --working;
    return out;
  });
  std::atomic<int> wrong{0};
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < kThreads; ++t)
      threads.emplace_back([&, t] {
        for (int i = 0; i < kEach; ++i) wrong += gather.run(t * kEach + i) != 10 * (t * kEach + i);
      });
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(answered, kThreads * kEach);
}

TEST(Gather, ThoseWhoWaitAreServedTogether) {
  std::latch begun(1), go(1);
  std::vector<size_t> sizes;
  Gather<int, int> gather([&](std::span<const int> in) {
    sizes.push_back(in.size());
    if (sizes.size() == 1) {
      begun.count_down();
      go.wait();
    }
    return std::vector<int>(in.begin(), in.end());
  });
  std::vector<std::jthread> threads;
  threads.emplace_back([&] { gather.run(0); });
  begun.wait();
  std::atomic<int> coming{0};
  for (int t = 1; t < 5; ++t)
    threads.emplace_back([&, t] {
      ++coming;
      EXPECT_EQ(gather.run(t), t);
    });
  while (coming < 4) std::this_thread::yield();
  std::this_thread::sleep_for(std::chrono::milliseconds(50));  // they stand in line by then
  go.count_down();
  threads.clear();
  size_t all = 0;
  for (size_t n : sizes) all += n;
  EXPECT_EQ(all, 5u);
  EXPECT_LT(sizes.size(), 5u);
}

TEST(Gather, WhatIsThrownReachesOneCallerAndHoldsUpNone) {
  std::atomic<int> calls{0};
  Gather<int, int> gather([&](std::span<const int> in) {
    if (++calls % 3 == 1) throw std::runtime_error("now and then");
    return std::vector<int>(in.begin(), in.end());
  });
  std::atomic<int> answered{0}, thrown{0};
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 6; ++t)
      threads.emplace_back([&, t] {
        for (int i = 0; i < 50; ++i) {
          try {
            answered += gather.run(t) == t;
          } catch (const std::runtime_error&) {
            ++thrown;
          }
        }
      });
  }
  EXPECT_EQ(answered + thrown, 300);
  EXPECT_GT(thrown, 0);
  EXPECT_GT(answered, 0);
}

}  // namespace
}  // namespace qray::server
