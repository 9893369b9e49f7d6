#include "server/store/job_store.h"

#include <gtest/gtest.h>

#include <thread>

#include "tests/support/scratch.h"

namespace qray::server {
namespace {

using std::chrono::milliseconds;
using enum JobState;

class JobStoreTest : public ::testing::Test {
 protected:
  void SetUp() override { open(); }
  // As after a restart of the server.
  void open() {
    store_.reset();
    events_ = std::make_unique<EventLog>();
    db_.reset();
    Result<std::unique_ptr<Database>> db = Database::open(scratch_ / "jobs.sqlite");
    ASSERT_TRUE(db.ok()) << db.error().text();
    db_ = std::move(db).value();
    store_ = std::make_unique<JobStore>(*db_, *events_, [this] { return now_ms_; });
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
  std::unique_ptr<Database> db_;
  std::unique_ptr<JobStore> store_;
  std::vector<JobId> recovered_;
};

TEST_F(JobStoreTest, InsertAndGet) {
  JobRequest request;
  request.set(field::kScene, "box");
  request.set(field::kSeconds, 0.1);
  request.set(field::kSeed, UINT64_MAX);
  request.set("camera/position", Vector3{0.1, 0.2, 0.3});
  const JobRecord job = get(insert(request));
  EXPECT_EQ(job.request, request);
  EXPECT_EQ(job.state, kQueued);
  EXPECT_EQ(job.created_ms, 1000);
  EXPECT_EQ(job.started_ms, std::nullopt);
  EXPECT_EQ(kinds_after(0), std::vector<std::string>{"state"});
  const Result<JobRecord> missing = store_->get({99});
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
}

TEST_F(JobStoreTest, MovesWriteRecordAndEvents) {
  const JobId id = insert();
  now_ms_ = 2000;
  move(id, {kPreparing});
  EXPECT_EQ(get(id).started_ms, 2000);
  EXPECT_EQ(get(id).attempts, 1);
  move(id, {kRendering, kFinalizing});
  now_ms_ = 3000;
  JobStore::Change change;
  change.events.push_back({0, id.text(), "table", "{}"});
  change.edit = [](JobRecord& job) {
    job.table_out = "t";
    job.stats_json = "{}";
    job.biased = true;
    job.progress = {1, 8, 2.5};
    job.warnings = {"one\nline", "two"};
  };
  ASSERT_TRUE(store_->move(id, kSucceeded, change).ok());
  const JobRecord job = get(id);
  EXPECT_EQ(job.state, kSucceeded);
  EXPECT_EQ(job.ended_ms, 3000);
  EXPECT_EQ(job.table_out, "t");
  EXPECT_EQ(job.progress.seconds, 2.5);
  EXPECT_TRUE(job.biased);
  EXPECT_EQ(job.warnings, (std::vector<std::string>{"one line", "two"}));
  EXPECT_EQ(kinds_after(0), (std::vector<std::string>{"state", "state", "state", "state", "table",
                                                      "state", "done"}));
}

TEST_F(JobStoreTest, IllegalMovesChangeNothing) {
  const JobId id = insert();
  const uint64_t newest = events_->newest();
  const Result<JobRecord> moved = store_->move(id, kSucceeded);
  ASSERT_FALSE(moved.ok());
  EXPECT_EQ(moved.error().code, ErrorCode::kConflict);
  EXPECT_EQ(get(id).state, kQueued);
  EXPECT_EQ(events_->newest(), newest);
}

TEST_F(JobStoreTest, AFailedWriteUndoesTheWholeMove) {
  const JobId id = insert();
  const uint64_t newest = events_->newest();
  JobStore::Change change;
  change.also = [](Database::Session&) { return Status(Error{ErrorCode::kIo, "full", ""}); };
  EXPECT_FALSE(store_->move(id, kPreparing, change).ok());
  EXPECT_EQ(get(id).state, kQueued);
  EXPECT_EQ(events_->newest(), newest);
  move(id, {kPreparing});  // and the store goes on
}

TEST_F(JobStoreTest, ListsNewestFirst) {
  for (int i = 0; i < 5; ++i) insert();
  const auto ids = [&](size_t limit, std::optional<JobId> before) {
    std::vector<uint64_t> ids;
    const Result<std::vector<JobRecord>> jobs = store_->list(limit, {before});
    for (const JobRecord& job : jobs.value()) ids.push_back(job.id.value);
    return ids;
  };
  EXPECT_EQ(ids(3, {}), (std::vector<uint64_t>{5, 4, 3}));
  EXPECT_EQ(ids(3, JobId{3}), (std::vector<uint64_t>{2, 1}));
}

TEST_F(JobStoreTest, ListsByStateAndLabel) {
  JobRequest request;
  request.set(field::kScene, "box");
  for (const char* project : {"lobby", "hall", "lobby", "l'\"obby"}) {
    request.set(field::kLabels, {{"project", project}, {"kind", "test"}});
    insert(request);
  }
  move({1}, {kCanceled});
  const auto ids = [&](const JobStore::Filter& filter) {
    std::vector<uint64_t> ids;
    const Result<std::vector<JobRecord>> jobs = store_->list(10, filter);
    for (const JobRecord& job : jobs.value()) ids.push_back(job.id.value);
    return ids;
  };
  using Labels = std::vector<std::pair<std::string, std::string>>;
  using Ids = std::vector<uint64_t>;
  const Labels lobby{{"project", "lobby"}};
  EXPECT_EQ(ids({{}, {}, lobby}), (Ids{3, 1}));
  EXPECT_EQ(ids({{}, {}, {{"project", "l'\"obby"}}}), (Ids{4}));
  EXPECT_EQ(ids({{}, {kQueued}, lobby}), (Ids{3}));
  EXPECT_EQ(ids({JobId{4}, {kQueued}, {}}), (Ids{3, 2}));
  EXPECT_TRUE(ids({{}, {}, {{"none", "lobby"}}}).empty());
  // Several states: one of them. Several labels: all of them.
  EXPECT_EQ(ids({{}, {kQueued, kCanceled}, lobby}), (Ids{3, 1}));
  EXPECT_EQ(ids({JobId{4}, {kCanceled, kQueued}, {}}), (Ids{3, 2, 1}));
  EXPECT_EQ(ids({{}, {}, {{"kind", "test"}, {"project", "hall"}}}), (Ids{2}));
  EXPECT_EQ(ids({{}, {kQueued, kSucceeded}, {{"kind", "test"}, {"project", "lobby"}}}), (Ids{3}));
  EXPECT_TRUE(ids({{}, {}, {{"project", "lobby"}, {"project", "hall"}}}).empty());
  EXPECT_EQ(store_->count().value().by_state,
            (std::map<JobState, uint64_t>{{kQueued, 3}, {kCanceled, 1}}));
  // By the table that they used or made, with the others beside it.
  for (const char* sql : {"UPDATE jobs SET table_in='t' WHERE id IN (2, 3)",
                          "UPDATE jobs SET table_out='t' WHERE id IN (3, 4)"})
    ASSERT_TRUE(Database::Session(*db_).exec(sql).ok());
  EXPECT_EQ(ids({{}, {}, {}, "t"}), (Ids{4, 3, 2}));
  EXPECT_EQ(ids({JobId{4}, {kQueued, kSucceeded}, {}, "t"}), (Ids{3, 2}));
  EXPECT_EQ(ids({{}, {kQueued}, lobby, "t"}), (Ids{3}));
  EXPECT_TRUE(ids({{}, {kCanceled}, {}, "t"}).empty());
  EXPECT_TRUE(ids({{}, {}, {}, "u"}).empty());
}

TEST_F(JobStoreTest, FiltersFindWhatMatchesAmongManyJobs) {
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

TEST_F(JobStoreTest, ReadersAndHintsWaitForNoWriter) {
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

TEST_F(JobStoreTest, ADamagedRowIsAFailedJobAndHarmsNoOther) {
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

TEST_F(JobStoreTest, AKeyGivesTheSameJobForADay) {
  JobRequest request;
  request.set(field::kScene, "box");
  const JobStore::IdempotencyKey key{"k", "hash"};
  const JobId id = insert(request, key);
  open();  // after a restart too
  EXPECT_EQ(insert(request, key), id);
  const JobStore::Posted other{request, {{"k", "another"}}};
  EXPECT_EQ(store_->insert({&other, 1}, 1)[0].error().code, ErrorCode::kConflict);
  EXPECT_GT(insert(request, {{"K", "hash"}}), id);
  now_ms_ += 24 * 3600 * 1000 + 1;
  EXPECT_GT(insert(request, key), id);
}

TEST_F(JobStoreTest, ManyAreInsertedAtOnceAsOneByOne) {
  const auto posted = [](uint64_t seed, const char* key) {
    JobStore::Posted one;
    one.request.set(field::kScene, "box");
    one.request.set(field::kSeed, seed);
    if (*key) one.key = {key, std::to_string(seed)};
    return one;
  };
  const JobId known = insert(posted(1, "a").request, posted(1, "a").key);
  const uint64_t before = events_->newest();
  const std::vector<JobStore::Posted> all = {posted(2, ""),  posted(1, "a"), posted(3, "b"),
                                             posted(3, "b"), posted(4, "b"), posted(5, ""),
                                             posted(6, ""),  posted(1, "a")};
  const auto inserted = store_->insert(all, 3);
  ASSERT_EQ(inserted.size(), all.size());
  for (const size_t i : {0, 2, 5}) EXPECT_TRUE(inserted[i].value().is_new) << i;
  for (const size_t i : {1, 3, 7}) EXPECT_FALSE(inserted[i].value().is_new) << i;
  EXPECT_EQ(inserted[1].value().job.id, known);
  EXPECT_EQ(inserted[3].value().job.id, inserted[2].value().job.id);
  EXPECT_EQ(inserted[7].value().job.id, known);  // known without any room
  EXPECT_EQ(inserted[4].error().code, ErrorCode::kConflict);
  EXPECT_EQ(inserted[6].error().code, ErrorCode::kBusy);
  EXPECT_EQ(get(inserted[5].value().job.id).request.get(field::kSeed), 5u);
  EXPECT_EQ(kinds_after(before), (std::vector<std::string>(3, "state")));
}

TEST_F(JobStoreTest, LogsHoldWhatHappenedLast) {
  const JobId id = insert(), other = insert();
  move(id, {kPreparing});
  store_->log(id, "warning", "a stone\nfell");
  const auto lines = store_->log_of(id).value();
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[0].text, "queued");
  EXPECT_EQ(lines[1].text, "preparing");
  EXPECT_EQ(lines[2].level, "warning");
  for (int i = 0; i < JobStore::kLogLines + 5; ++i) store_->log(id, "info", std::to_string(i));
  const auto last = store_->log_of(id).value();
  EXPECT_EQ(last.size(), static_cast<size_t>(JobStore::kLogLines));
  EXPECT_EQ(last.back().text, std::to_string(JobStore::kLogLines + 4));
  EXPECT_EQ(store_->log_of(other).value().size(), 1u);
}

TEST_F(JobStoreTest, OnlyEndedJobsAreForgotten) {
  const JobId open_job = insert(), ended = insert();
  move(ended, {kCanceled});
  EXPECT_EQ(store_->remove(open_job).error().code, ErrorCode::kConflict);
  const uint64_t newest = events_->newest();
  ASSERT_TRUE(store_->remove(ended).ok());
  EXPECT_EQ(store_->get(ended).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(store_->remove(ended).error().code, ErrorCode::kNotFound);
  EXPECT_TRUE(store_->log_of(ended).value().empty());
  EXPECT_EQ(kinds_after(newest), std::vector<std::string>{"deleted"});
  EXPECT_GT(insert(), ended);  // its number is not used again
  EXPECT_EQ(store_->ended_before(INT64_MAX, 10).value().size(), 0u);
}

// What version 1 of the schema left is read by this one.
TEST_F(JobStoreTest, AnOlderSchemaIsBroughtUpToDate) {
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
          "DROP TABLE idempotency_keys", "DROP INDEX events_by_job", "PRAGMA user_version=1"})
      ASSERT_TRUE(session.exec(sql).ok()) << sql;
  }
  open();
  EXPECT_EQ(store_->list(10, {{}, {}, {{"project", "lobby"}}}).value().size(), 1u);
  EXPECT_EQ(recovered_, std::vector<JobId>{id});
  store_->log(id, "info", "here");
  EXPECT_EQ(store_->log_of(id).value().size(), 1u);
}

TEST_F(JobStoreTest, RestartQueuesWhatWasOpen) {
  const JobId queued = insert(), rendering = insert(), canceling = insert(), ended = insert();
  const JobId pausing = insert(), paused = insert();
  move(pausing, {kPreparing, kPausing});
  move(paused, {kPaused});
  move(rendering, {kPreparing, kLearning, kRendering});
  move(canceling, {kPreparing, kCanceling});
  move(ended, {kPreparing, kRendering, kFinalizing, kSucceeded});
  open();
  EXPECT_EQ(recovered_, (std::vector<JobId>{queued, rendering}));
  EXPECT_EQ(get(rendering).state, kQueued);
  EXPECT_EQ(get(canceling).state, kCanceled);
  EXPECT_EQ(get(pausing).state, kPaused);
  EXPECT_EQ(get(paused).state, kPaused);
  EXPECT_EQ(get(ended).state, kSucceeded);
}

TEST_F(JobStoreTest, AJobThatEndsTheServerThreeTimesFails) {
  const JobId id = insert();
  for (int attempt = 1; attempt <= kMaxAttempts; ++attempt) {
    ASSERT_EQ(get(id).state, kQueued) << attempt;
    move(id, {kPreparing, kRendering});
    open();
  }
  EXPECT_TRUE(recovered_.empty());
  EXPECT_EQ(get(id).state, kFailed);
  EXPECT_TRUE(get(id).error.has_value());
}

TEST_F(JobStoreTest, AJobThatGetsSomewhereMayBeInterruptedAnyNumberOfTimes) {
  const JobId id = insert();
  for (int attempt = 1; attempt <= 2 * kMaxAttempts; ++attempt) {
    ASSERT_EQ(get(id).state, kQueued) << attempt;
    move(id, {kPreparing, kRendering});
    ASSERT_TRUE(store_->reset_attempts(id).ok());
    open();
  }
}

TEST_F(JobStoreTest, EventIdsRiseAcrossRestartsAndReadersGoOn) {
  const JobId id = insert();
  const uint64_t seen = events_->newest();
  move(id, {kCanceled});
  store_->publish_hint({0, id.text(), "progress", "{}"});
  const uint64_t hint = events_->newest();
  open();
  EXPECT_GT(events_->newest(), hint);
  EXPECT_EQ(kinds_after(seen), (std::vector<std::string>{"state", "done"}));
  EXPECT_TRUE(kinds_after(hint).empty());
  EXPECT_FALSE(events_->wait(hint, "", milliseconds(0)).reset);
  insert();
  EXPECT_EQ(kinds_after(hint), std::vector<std::string>{"state"});
}

TEST_F(JobStoreTest, EventIdsRiseInADamagedFolderToo) {
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

TEST_F(JobStoreTest, OldEventsAreForgottenAtARestart) {
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

TEST_F(JobStoreTest, ANewerSchemaIsRefused) {
  {
    Database::Session session(*db_);
    ASSERT_TRUE(session.exec("PRAGMA user_version=99").ok());
  }
  store_.reset();
  db_.reset();
  const Result<std::unique_ptr<Database>> db = Database::open(scratch_ / "jobs.sqlite");
  ASSERT_FALSE(db.ok());
  EXPECT_EQ(db.error().code, ErrorCode::kUnsupported);
}

TEST_F(JobStoreTest, AFileThatIsNoDatabaseIsRefused) {
  const auto path = scratch_ / "not.sqlite";
  std::FILE* file = std::fopen(path.c_str(), "w");
  std::fputs(std::string(5000, 'x').c_str(), file);
  std::fclose(file);
  EXPECT_FALSE(Database::open(path).ok());
}

}  // namespace
}  // namespace qray::server
