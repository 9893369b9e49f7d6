// What is SQLite's own; what any store must do is in tests/server/store/store_conformance_test.cpp.
#include "server/sqlite/sqlite_job_store.h"

#include <gtest/gtest.h>

#include <thread>

#include "tests/server/store/job_store_steps.h"

namespace qray::server {
namespace {

using std::chrono::milliseconds;
using enum JobState;

class SqliteJobStoreTest : public test::JobStoreSteps {
 protected:
  void SetUp() override { open(); }
  // As after a restart of the server.
  void open() {
    sqlite_.reset();
    events_ = std::make_unique<EventLog>();
    db_.reset();
    Result<std::unique_ptr<Database>> db = Database::open(scratch_ / "jobs.sqlite");
    ASSERT_TRUE(db.ok()) << db.error().text();
    db_ = std::move(db).value();
    sqlite_ = std::make_unique<SqliteJobStore>(*db_, *events_, [this] { return now_ms_.load(); });
    recover(*sqlite_);
  }

  std::unique_ptr<Database> db_;
  std::unique_ptr<SqliteJobStore> sqlite_;
};

TEST_F(SqliteJobStoreTest, AFailedWriteUndoesTheWholeMove) {
  const JobId id = insert();
  const uint64_t newest = events_->newest();
  ASSERT_TRUE(Database::Session(*db_)
                  .exec("CREATE TRIGGER full BEFORE INSERT ON tables BEGIN SELECT RAISE(ABORT, "
                        "'full'); END")
                  .ok());
  JobStore::Change change;
  change.table = TableRow{};
  EXPECT_FALSE(store_->move(id, kPreparing, change).ok());
  EXPECT_EQ(get(id).state, kQueued);
  EXPECT_EQ(events_->newest(), newest);
  move(id, {kPreparing});  // and the store goes on
}

TEST_F(SqliteJobStoreTest, FiltersFindWhatMatchesAmongManyJobs) {
  JobRequest request;
  request.set(field::kScene, "box");
  request.set(field::kLabels, {{"project", "lobby"}});
  insert(request);
  const char* many =
      "INSERT INTO jobs(state, request, created_ms, stats) WITH RECURSIVE n(i) AS (SELECT 1 UNION "
      "ALL SELECT i + 1 FROM n WHERE i < 2000) SELECT 'succeeded', (SELECT request FROM jobs), i, "
      "hex(zeroblob(1000)) FROM n";
  ASSERT_TRUE(Database::Session(*db_).exec(many).ok());
  const JobStore::Filter filters[] = {{{}, {}, {{"project", "hall"}}},
                                      {{}, {}, {}, "t"},
                                      {{}, {kFailed}},
                                      {{}, {kFailed, kCanceled}, {{"project", "lobby"}}}};
  for (const JobStore::Filter& filter : filters)
    EXPECT_TRUE(store_->list(50, filter).value().empty());
  EXPECT_EQ(store_->list(50, {{}, {kSucceeded}, {{"project", "lobby"}}}).value().size(), 50u);
}

TEST_F(SqliteJobStoreTest, ReadersAndHintsWaitForNoWriter) {
  const JobId id = insert();
  const uint64_t before = events_->newest();
  {
    const Database::Transaction writes(*db_);
    std::thread others([&] {
      EXPECT_EQ(get(id).state, kQueued);
      EXPECT_EQ(store_->list(10, {}).value().size(), 1u);
      EXPECT_EQ(store_->count().value().by_state.size(), 1u);
      EXPECT_EQ(store_->log_of(id).value().size(), 1u);
      store_->publish_hint({0, id.text(), "progress", "{}"});
    });
    others.join();
    EXPECT_EQ(events_->newest(), before);
  }
  move(id, {kCanceled});  // what waited comes first
  EXPECT_EQ(kinds_after(before), (std::vector<std::string>{"progress", "state", "done"}));
}

TEST_F(SqliteJobStoreTest, ADamagedRowIsAFailedJobAndHarmsNoOther) {
  const JobId queued = insert(), ended = insert(), whole = insert();
  move(ended, {kPreparing, kRendering, kFinalizing, kSucceeded});
  const auto damage = [&](JobId id, const char* column, const char* value) {
    Database::Session session(*db_);
    const std::string sql = std::string("UPDATE jobs SET ") + column + "=? WHERE id=?";
    ASSERT_TRUE(Query(session.handle(), sql.c_str()).bind(value).bind(id.value).run().ok());
  };
  ASSERT_TRUE(Database::Session(*db_).exec("DROP TRIGGER labels_of_a_changed_job").ok());
  damage(queued, "request", "{\"scene\":");
  damage(ended, "state", "dreaming");
  open();
  EXPECT_EQ(recovered_, std::vector<JobId>{whole});
  ASSERT_EQ(store_->list(10, {}).value().size(), 3u);
  EXPECT_EQ(store_->list(10, {{}, {kFailed}}).value().size(), 2u);
  for (const JobId id : {queued, ended}) {
    const JobRecord job = get(id);
    EXPECT_EQ(job.state, kFailed);
    EXPECT_NE(job.error->message.find("damaged"), std::string::npos);
    EXPECT_FALSE(store_->move(id, kQueued).ok());
    EXPECT_TRUE(store_->remove(id).ok());
  }
  EXPECT_TRUE(store_->remove_scene("hall", [] { return Status(); }).ok());
  EXPECT_EQ(store_->remove_scene("box", [] { return Status(); }).error().code,
            ErrorCode::kConflict);
}

// What version 1 of the schema left is read by this one.
TEST_F(SqliteJobStoreTest, AnOlderSchemaIsBroughtUpToDate) {
  JobRequest request;
  request.set(field::kScene, "box");
  request.set(field::kLabels, {{"project", "lobby"}});
  const JobId id = insert(request);
  {
    Database::Session session(*db_);
    for (const char* sql :
         {"DROP TRIGGER labels_of_a_new_job", "DROP TRIGGER labels_of_a_changed_job",
          "DROP TRIGGER labels_of_a_deleted_job", "DROP TABLE job_labels",
          "DROP INDEX jobs_by_table_in", "DROP INDEX jobs_by_table_out", "DROP TABLE job_log",
          "DROP TABLE idempotency_keys", "DROP INDEX events_by_job", "DROP TABLE webhooks",
          "DROP TABLE deliveries", "DROP INDEX jobs_by_times", "ALTER TABLE jobs DROP COLUMN claim",
          "PRAGMA user_version=1"})
      ASSERT_TRUE(session.exec(sql).ok()) << sql;
  }
  open();
  EXPECT_EQ(store_->list(10, {{}, {}, {{"project", "lobby"}}}).value().size(), 1u);
  EXPECT_EQ(recovered_, std::vector<JobId>{id});
  store_->log(id, "info", "here");
  EXPECT_EQ(store_->log_of(id).value().size(), 1u);
}

TEST_F(SqliteJobStoreTest, EventIdsRiseInADamagedFolderToo) {
  {
    Database::Session session(*db_);
    for (const int64_t id : {int64_t{-5}, int64_t{0}, int64_t{1} << 40})
      ASSERT_TRUE(Query(session.handle(), "INSERT INTO events VALUES(?,'j','state','{}')")
                      .bind(id)
                      .run()
                      .ok());
  }
  open();
  EXPECT_EQ(events_->newest(), uint64_t{1} << 40);
  insert();
  EXPECT_GT(events_->newest(), uint64_t{1} << 40);
}

TEST_F(SqliteJobStoreTest, OldEventsAreForgottenAtARestart) {
  {
    Database::Transaction transaction(*db_);
    for (int id = 100; id < 2200; ++id) {
      ASSERT_TRUE(Query(transaction.handle(), "INSERT INTO events VALUES(?,'j','state','{}')")
                      .bind(id)
                      .run()
                      .ok());
    }
    ASSERT_TRUE(transaction.commit().ok());
  }
  insert();  // reserves ids, which start below
  open();
  EXPECT_TRUE(events_->wait(150, "", milliseconds(0)).reset);
  EXPECT_FALSE(events_->wait(2100, "", milliseconds(0)).reset);
}

TEST_F(SqliteJobStoreTest, ANewerSchemaIsRefused) {
  {
    Database::Session session(*db_);
    ASSERT_TRUE(session.exec("PRAGMA user_version=99").ok());
  }
  sqlite_.reset();
  db_.reset();
  const Result<std::unique_ptr<Database>> db = Database::open(scratch_ / "jobs.sqlite");
  ASSERT_FALSE(db.ok());
  EXPECT_EQ(db.error().code, ErrorCode::kUnsupported);
}

TEST_F(SqliteJobStoreTest, AFileThatIsNoDatabaseIsRefused) {
  const auto path = scratch_ / "not.sqlite";
  std::FILE* file = std::fopen(path.c_str(), "w");
  std::fputs(std::string(5000, 'x').c_str(), file);
  std::fclose(file);
  EXPECT_FALSE(Database::open(path).ok());
}

}  // namespace
}  // namespace qray::server
