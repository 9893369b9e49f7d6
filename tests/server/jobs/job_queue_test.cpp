#include "server/jobs/job_queue.h"

#include <gtest/gtest.h>

#include <thread>

namespace qray::server {
namespace {

TEST(JobQueue, OldestFirstAndTellsItsRoom) {
  JobQueue queue(2);
  EXPECT_EQ(queue.room(), 2u);
  queue.push({1}, 0);
  EXPECT_EQ(queue.room(), 1u);
  queue.push({2}, 0);
  queue.push({4}, 0);  // accepted before a restart
  EXPECT_EQ(queue.room(), 0u);
  EXPECT_EQ(queue.pop({}), JobId{1});
  EXPECT_TRUE(queue.remove({2}));
  EXPECT_FALSE(queue.remove({2}));
  EXPECT_EQ(queue.pop({}), JobId{4});
  EXPECT_EQ(queue.size(), 0u);
}

TEST(JobQueue, APriorityIsChangedAndTheWaitCounts) {
  using std::chrono::minutes;
  JobQueue queue(10);
  const auto now = JobQueue::Clock::now();
  queue.push({1}, 0, now);
  queue.push({2}, 0, now + minutes(3));
  queue.push({3}, 0, now + minutes(4));
  queue.set_priority({3}, 5);
  queue.set_priority({2}, 2);  // a minute after the first
  queue.set_priority({4}, 5);
  for (const uint64_t id : {3, 1, 2}) EXPECT_EQ(queue.pop({}), JobId{id});
  EXPECT_EQ(queue.size(), 0u);
}

TEST(JobQueue, HigherPriorityFirstAndNoneWaitsForEver) {
  using std::chrono::minutes;
  JobQueue queue(10);
  const auto now = JobQueue::Clock::now();
  for (const auto& [id, priority, at] :
       {std::tuple{1u, -5, 0}, {2u, 0, 0}, {3u, 2, 0}, {4u, 0, 0}, {5u, 2, 6}, {6u, 2, 9}})
    queue.push({id}, priority, now + minutes(at));
  std::vector<uint64_t> order;
  while (queue.size() > 0) order.push_back(queue.pop({})->value);
  // 3 was asked for first of all that count as old; 1 has waited longer than 6 before that came.
  EXPECT_EQ(order, (std::vector<uint64_t>{3, 2, 4, 5, 1, 6}));
}

TEST(JobQueue, PopWaits) {
  JobQueue queue(2);
  std::jthread feeder([&] { queue.push({7}, 0); });
  EXPECT_EQ(queue.pop({}), JobId{7});
}

TEST(JobQueue, PopEndsWhenStopped) {
  JobQueue queue(2);
  std::stop_source stop;
  std::jthread stopper([&] { stop.request_stop(); });
  EXPECT_EQ(queue.pop(stop.get_token()), std::nullopt);
  queue.push({1}, 0);
  EXPECT_EQ(queue.pop(stop.get_token()), std::nullopt);
}

}  // namespace
}  // namespace qray::server
