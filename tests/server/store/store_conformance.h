// What any store of jobs and tables must do is asked of each in kStores. A store is a row there:
// how it is opened on a folder, again and again.
#pragma once

#include <gtest/gtest.h>

#include "server/sqlite/sqlite_records.h"
#include "tests/server/store/job_store_steps.h"
#ifdef QRAY_POSTGRES
#include "server/postgres/pg_records.h"
#include "tests/support/postgres_server.h"
#endif

namespace qray::server::test {

using enum JobState;

// Where a store is, and how it is opened there again and again. A place of null: not on this
// machine.
struct StoreKind {
  const char* name;
  std::optional<std::string> (*place)(const std::filesystem::path& folder);
  Result<std::unique_ptr<Records>> (*open)(const std::string& place, EventLog& events,
                                           const std::function<int64_t()>& now_ms);
};
inline constexpr StoreKind kStores[] = {
    {"Sqlite",
     [](const std::filesystem::path& folder) -> std::optional<std::string> {
       return folder / "jobs.sqlite";
     },
     [](const std::string& place, EventLog& events, const std::function<int64_t()>& now_ms) {
       return SqliteRecords::open(place, events, now_ms);
     }},
#ifdef QRAY_POSTGRES
    // Leases are over at once: who opens the store again is believed to be the only one.
    {"Postgres",
     [](const std::filesystem::path&) -> std::optional<std::string> {
       auto* server = qray::test::PostgresServer::instance();
       if (!server) return {};
       return server->url(server->new_schema());
     },
     [](const std::string& place, EventLog& events, const std::function<int64_t()>& now_ms) {
       return open_pg_records(place, events, now_ms, {true, std::chrono::milliseconds(0)});
     }},
#endif
};

class StoreTest : public JobStoreSteps, public ::testing::WithParamInterface<StoreKind> {
 protected:
  void SetUp() override {
    place_ = GetParam().place(scratch_.path());
    if (!place_) GTEST_SKIP() << "there is no such database here: bash docker/install.sh test";
    open();
  }
  // As after a restart of the server.
  void open() {
    open_.reset();
    events_ = std::make_unique<EventLog>();
    auto opened = GetParam().open(*place_, *events_, [this] { return now_ms_.load(); });
    ASSERT_TRUE(opened.ok()) << opened.error().text();
    open_ = std::move(opened).value();
    recover(open_->jobs());
  }

  std::optional<std::string> place_;
  std::unique_ptr<Records> open_;
};

}  // namespace qray::server::test
