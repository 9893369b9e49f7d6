#include "server/store/event_log.h"

#include <gtest/gtest.h>

#include <thread>

namespace qray::server {
namespace {

using std::chrono::milliseconds;

std::vector<uint64_t> ids(const EventLog::Batch& batch) {
  std::vector<uint64_t> ids;
  for (const Event& e : batch.events) ids.push_back(e.id);
  return ids;
}

TEST(EventLog, GivesWhatFollowsTheCursor) {
  EventLog log;
  for (uint64_t id : {1, 2, 5}) log.publish({id, id == 2 ? "b" : "a", "state", "{}"});
  EXPECT_EQ(ids(log.wait(0, "", milliseconds(0))), (std::vector<uint64_t>{1, 2, 5}));
  EXPECT_EQ(ids(log.wait(2, "", milliseconds(0))), (std::vector<uint64_t>{5}));
  EXPECT_EQ(ids(log.wait(3, "", milliseconds(0))), (std::vector<uint64_t>{5}));
  const EventLog::Batch of_b = log.wait(0, "b", milliseconds(0));
  EXPECT_EQ(ids(of_b), (std::vector<uint64_t>{2}));
  EXPECT_EQ(of_b.cursor, 5u);
  EXPECT_TRUE(log.wait(5, "", milliseconds(0)).events.empty());
}

TEST(EventLog, ReadersBehindTheRingAreReset) {
  EventLog log(3);
  for (uint64_t id = 1; id <= 5; ++id) log.publish({id, "a", "state", "{}"});
  const EventLog::Batch lost = log.wait(1, "", milliseconds(0));
  EXPECT_TRUE(lost.reset);
  EXPECT_EQ(lost.cursor, 5u);
  EXPECT_TRUE(lost.events.empty());
  const EventLog::Batch kept = log.wait(2, "", milliseconds(0));
  EXPECT_FALSE(kept.reset);
  EXPECT_EQ(ids(kept), (std::vector<uint64_t>{3, 4, 5}));
  EXPECT_TRUE(log.wait(6, "", milliseconds(0)).reset);  // not one of ours
}

TEST(EventLog, RestoredEventsAreKnownOlderOnesLost) {
  EventLog log;
  log.restore(6, {{7, "a", "state", "{}"}, {9, "a", "done", "{}"}}, 20);
  EXPECT_TRUE(log.wait(5, "", milliseconds(0)).reset);
  EXPECT_EQ(ids(log.wait(6, "", milliseconds(0))), (std::vector<uint64_t>{7, 9}));
  EXPECT_FALSE(log.wait(15, "", milliseconds(0)).reset);
  EXPECT_EQ(log.newest(), 20u);
}

TEST(EventLog, WaitsForTheNext) {
  EventLog log;
  std::jthread writer([&] { log.publish({1, "a", "state", "{}"}); });
  EXPECT_EQ(ids(log.wait(0, "", milliseconds(10'000))), (std::vector<uint64_t>{1}));
}

TEST(EventLog, CloseEndsWaits) {
  EventLog log;
  std::jthread closer([&] { log.close(); });
  EXPECT_TRUE(log.wait(0, "", milliseconds(60'000)).events.empty());
  EXPECT_TRUE(log.closed());
}

}  // namespace
}  // namespace qray::server
