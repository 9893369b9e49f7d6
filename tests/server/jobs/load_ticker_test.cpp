#include "server/jobs/load_ticker.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "server/sqlite/sqlite_job_store.h"
#include "tests/support/scratch.h"

namespace qray::server {
namespace {

class TurnedClock final : public Clock {
 public:
  double seconds() const override { return now; }
  double now = 100;
};

class LoadTickerTest : public ::testing::Test {
 protected:
  LoadTickerTest()
      : db_(Database::open(scratch_ / "jobs.sqlite").value()),
        jobs_(*db_, events_, [] { return int64_t{0}; }) {
    (void)jobs_.recover();
  }
  std::vector<Event> events() { return events_.wait(0, "", std::chrono::milliseconds(0)).events; }
  qray::test::ScratchFolder scratch_;
  EventLog events_;
  std::unique_ptr<Database> db_;
  SqliteJobStore jobs_;
  TurnedClock clock_;
  std::stop_source stop_;
};

TEST_F(LoadTickerTest, TellsAtMostTwiceASecond) {
  LoadTicker ticker(jobs_, JobId{7}, clock_, stop_.get_token());
  const LoadWatch watch = ticker.watch();
  for (int i = 0; i <= 100; ++i) {
    EXPECT_TRUE(watch(i < 60 ? LoadStep::kReading : LoadStep::kBuilding, i / 100.0));
    clock_.now += 0.015625;
  }
  const std::vector<Event> told = events();
  ASSERT_EQ(told.size(), 3u) << "in 1.6 s, nothing in the first half";
  EXPECT_EQ(told[0].kind, "loading");
  const auto first = nlohmann::json::parse(told[0].data);
  EXPECT_EQ(first["job"], "j000007");
  EXPECT_EQ(first["step"], "reading");
  EXPECT_EQ(first["fraction"], 0.32);
  EXPECT_EQ(first["seconds"], 0.5);
  EXPECT_EQ(nlohmann::json::parse(told[2].data)["step"], "building");
}

TEST_F(LoadTickerTest, EndsTheLoadingOfACanceledJob) {
  LoadTicker ticker(jobs_, JobId{7}, clock_, stop_.get_token());
  const LoadWatch watch = ticker.watch();
  EXPECT_TRUE(watch(LoadStep::kReading, 0));
  stop_.request_stop();
  EXPECT_FALSE(watch(LoadStep::kReading, 0.1));
  EXPECT_TRUE(events().empty());
}

}  // namespace
}  // namespace qray::server
