// What any store of jobs and tables must do is asked of each in kStores. A store is a row there:
// how it is opened on a folder, again and again.
#pragma once

#include <gtest/gtest.h>

#include "server/sqlite/sqlite_job_store.h"
#include "server/sqlite/sqlite_table_index.h"
#include "server/sqlite/sqlite_webhook_store.h"
#include "tests/server/store/job_store_steps.h"

namespace qray::server::test {

using enum JobState;

// A store that is open.
class OpenStore {
 public:
  virtual ~OpenStore() = default;
  virtual JobStore& jobs() = 0;
  virtual TableIndex& tables() = 0;
  virtual WebhookStore& webhooks() = 0;
};

class OpenSqlite final : public OpenStore {
 public:
  OpenSqlite(const std::filesystem::path& folder, EventLog& events, std::function<int64_t()> now_ms)
      : db_(Database::open(folder / "jobs.sqlite").value()),
        jobs_(*db_, events, now_ms),
        tables_(*db_),
        webhooks_(*db_, now_ms) {}
  JobStore& jobs() override { return jobs_; }
  TableIndex& tables() override { return tables_; }
  WebhookStore& webhooks() override { return webhooks_; }

 private:
  std::unique_ptr<Database> db_;
  SqliteJobStore jobs_;
  SqliteTableIndex tables_;
  SqliteWebhookStore webhooks_;
};

struct StoreKind {
  const char* name;
  std::unique_ptr<OpenStore> (*open)(const std::filesystem::path& folder, EventLog& events,
                                     std::function<int64_t()> now_ms);
};
inline constexpr StoreKind kStores[] = {
    {"Sqlite",
     [](const std::filesystem::path& folder, EventLog& events,
        std::function<int64_t()> now_ms) -> std::unique_ptr<OpenStore> {
       return std::make_unique<OpenSqlite>(folder, events, std::move(now_ms));
     }},
};

class StoreTest : public JobStoreSteps, public ::testing::WithParamInterface<StoreKind> {
 protected:
  void SetUp() override { open(); }
  // As after a restart of the server.
  void open() {
    open_.reset();
    events_ = std::make_unique<EventLog>();
    open_ = GetParam().open(scratch_.path(), *events_, [this] { return now_ms_; });
    recover(open_->jobs());
  }

  std::unique_ptr<OpenStore> open_;
};

}  // namespace qray::server::test
