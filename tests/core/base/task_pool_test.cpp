#include "core/base/task_pool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <latch>
#include <set>
#include <thread>

namespace qray {
namespace {

TEST(TaskPool, RunsEveryIndexOnce) {
  for (const int threads : {1, 2, 5}) {
    TaskPool pool(threads);
    EXPECT_EQ(pool.threads(), threads);
    for (const size_t count : {size_t{0}, size_t{1}, size_t{3}, size_t{1000}}) {
      std::vector<std::atomic<int>> runs(count);
      std::atomic<bool> wrong_worker = false;
      pool.run(count, [&](size_t i, int worker) {
        ++runs[i];
        if (worker < 0 || worker >= threads) wrong_worker = true;
      });
      for (size_t i = 0; i < count; ++i) EXPECT_EQ(runs[i], 1) << i << " of " << count;
      EXPECT_FALSE(wrong_worker);
    }
  }
}

TEST(TaskPool, OneThreadGoesInOrder) {
  TaskPool pool(1);
  std::vector<size_t> order;
  pool.run(100, [&](size_t i, int) { order.push_back(i); });
  for (size_t i = 0; i < order.size(); ++i) EXPECT_EQ(order[i], i);
}

TEST(TaskPool, WorkersRunAtTheSameTimeUnderTheirOwnNumbers) {
  TaskPool pool(3);
  std::latch all_here(3);  // passed only if three bodies run at once
  std::vector<int> workers(3, -1);
  pool.run(3, [&](size_t i, int worker) {
    all_here.arrive_and_wait();
    workers[i] = worker;
  });
  EXPECT_EQ(std::set<int>(workers.begin(), workers.end()), (std::set<int>{0, 1, 2}));
}

TEST(TaskPool, WaitsForTheLastAndCanBeUsedAgain) {
  TaskPool pool(4);
  size_t sum = 0;
  for (int round = 0; round < 300; ++round) {
    std::vector<size_t> part(4, 0);  // no atomics: run() must have returned after every body
    pool.run(17, [&](size_t i, int worker) { part[static_cast<size_t>(worker)] += i; });
    for (const size_t p : part) sum += p;
  }
  EXPECT_EQ(sum, size_t{300} * 136);
}

TEST(TaskPool, StopsBetweenTwoAndSaysHowManyWereDone) {
  for (const int threads : {1, 3}) {
    TaskPool pool(threads);
    std::vector<std::atomic<int>> runs(1000);
    std::atomic<bool> enough = false;
    const size_t done = pool.run_until(
        runs.size(),
        [&](size_t i, int) {
          ++runs[i];
          if (i == 400) enough = true;
        },
        [&] { return enough.load(); });
    EXPECT_GT(done, 400u);
    EXPECT_LE(done, 401u + static_cast<size_t>(threads));
    for (size_t i = 0; i < runs.size(); ++i) EXPECT_EQ(runs[i], i < done) << i;
    EXPECT_EQ(pool.run_until(
                  5, [](size_t, int) {}, [] { return true; }),
              0u);
    EXPECT_EQ(pool.run_until(
                  5, [](size_t, int) {}, [] { return false; }),
              5u);
  }
}

// Two loops of endless tasks of equal length: each is served by its weight.
TEST(TaskPool, SharesByWeightAndStarvesNone) {
  TaskPool light(2), heavy(light, 3);
  EXPECT_EQ(heavy.threads(), 2);
  std::atomic<int> lights = 0, heavies = 0;
  const auto enough = [&] { return lights + heavies >= 400; };
  const auto task = [](std::atomic<int>& count) {
    return [&count](size_t, int) {
      std::this_thread::sleep_for(std::chrono::microseconds(500));
      ++count;
    };
  };
  std::thread other([&] { heavy.run_until(1000, task(heavies), enough); });
  light.run_until(1000, task(lights), enough);
  other.join();
  // 3 to 1, less what one ran before the other was there.
  EXPECT_GT(lights, 50);
  EXPECT_GT(heavies, lights);
}

TEST(TaskPool, ALoopThatWasAwayGetsNoTimeBack) {
  TaskPool first(1), second(first, 1);
  const auto task = [](size_t, int) { std::this_thread::sleep_for(std::chrono::milliseconds(1)); };
  first.run(100, task);  // `second` does not want any
  std::atomic<int> firsts = 0, seconds = 0;
  const auto enough = [&] { return firsts + seconds >= 60; };
  std::thread other([&] {
    second.run_until(
        60, [&](size_t i, int w) { task(i, w), ++seconds; }, enough);
  });
  first.run_until(
      60, [&](size_t i, int w) { task(i, w), ++firsts; }, enough);
  other.join();
  EXPECT_GT(firsts, 5);
  EXPECT_GT(seconds, 5);
}

}  // namespace
}  // namespace qray
