#include "server/jobs/job_queue.h"

#include <gtest/gtest.h>

#include <thread>

namespace qray::server {
namespace {

TEST(JobQueue, OldestFirstAndBounded) {
  JobQueue queue(2);
  EXPECT_TRUE(queue.push({1}).ok());
  EXPECT_TRUE(queue.push({2}).ok());
  const Status full = queue.push({3});
  ASSERT_FALSE(full.ok());
  EXPECT_EQ(full.error().code, ErrorCode::kBusy);
  EXPECT_TRUE(queue.push({4}, /*keep_bound=*/false).ok());
  EXPECT_EQ(queue.pop({}), JobId{1});
  EXPECT_TRUE(queue.remove({2}));
  EXPECT_FALSE(queue.remove({2}));
  EXPECT_EQ(queue.pop({}), JobId{4});
  EXPECT_EQ(queue.size(), 0u);
}

TEST(JobQueue, PopWaits) {
  JobQueue queue(2);
  std::jthread feeder([&] { (void)queue.push({7}); });
  EXPECT_EQ(queue.pop({}), JobId{7});
}

TEST(JobQueue, PopEndsWhenStopped) {
  JobQueue queue(2);
  std::stop_source stop;
  std::jthread stopper([&] { stop.request_stop(); });
  EXPECT_EQ(queue.pop(stop.get_token()), std::nullopt);
  EXPECT_TRUE(queue.push({1}).ok());
  EXPECT_EQ(queue.pop(stop.get_token()), std::nullopt);
}

}  // namespace
}  // namespace qray::server
