#include "core/base/task_pool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <latch>
#include <set>

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

}  // namespace
}  // namespace qray
