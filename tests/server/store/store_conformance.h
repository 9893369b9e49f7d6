// What any store of jobs and tables must do is asked of each in kStores. A store is a row there:
// how it is opened on a folder, again and again.
#pragma once

#include <gtest/gtest.h>

#include "server/sqlite/sqlite_job_store.h"
#include "server/sqlite/sqlite_table_index.h"
#include "server/sqlite/sqlite_webhook_store.h"
#include "tests/support/scratch.h"

namespace qray::server::test {

using std::chrono::milliseconds;
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

class StoreTest : public ::testing::TestWithParam<StoreKind> {
 protected:
  void SetUp() override { open(); }
  // As after a restart of the server.
  void open() {
    open_.reset();
    events_ = std::make_unique<EventLog>();
    open_ = GetParam().open(scratch_.path(), *events_, [this] { return now_ms_; });
    store_ = &open_->jobs();
    const Result<std::vector<JobRecord>> recovered = store_->recover();
    ASSERT_TRUE(recovered.ok()) << recovered.error().text();
    recovered_.clear();
    for (const JobRecord& job : recovered.value()) recovered_.push_back(job.id);
  }
  JobId insert(const JobRequest& request, const std::optional<JobStore::IdempotencyKey>& key = {}) {
    const JobStore::Posted posted{request, key};
    auto inserted = store_->insert({&posted, 1}, 1);
    EXPECT_TRUE(inserted[0].ok());
    return inserted[0].ok() ? inserted[0].value().job.id : JobId{};
  }
  JobId insert() {
    JobRequest request;
    request.set(field::kScene, "box");
    request.set(field::kSamples, 8);
    return insert(request);
  }
  JobRecord get(JobId id) {
    Result<JobRecord> job = store_->get(id);
    EXPECT_TRUE(job.ok());
    return job.value();
  }
  void move(JobId id, std::initializer_list<JobState> states) {
    for (JobState to : states) {
      const Result<JobRecord> moved = store_->move(id, to);
      ASSERT_TRUE(moved.ok()) << moved.error().text();
    }
  }
  std::vector<std::string> kinds_after(uint64_t cursor) {
    std::vector<std::string> kinds;
    for (const Event& e : events_->wait(cursor, "", milliseconds(0)).events)
      kinds.push_back(e.kind);
    return kinds;
  }

  qray::test::ScratchFolder scratch_;
  int64_t now_ms_ = 1000;
  std::unique_ptr<EventLog> events_;
  std::unique_ptr<OpenStore> open_;
  JobStore* store_ = nullptr;
  std::vector<JobId> recovered_;
};

}  // namespace qray::server::test
