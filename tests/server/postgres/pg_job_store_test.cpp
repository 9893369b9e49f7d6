// What is PostgreSQL's own: several processes on one store, and a database that goes away. What any
// store must do is in tests/server/store/store_conformance_test.cpp.
#ifdef QRAY_POSTGRES
#include "server/postgres/pg_job_store.h"

#include <gtest/gtest.h>

#include <set>
#include <thread>

#include "tests/server/store/job_store_steps.h"
#include "tests/support/postgres_server.h"

namespace qray::server {
namespace {

using std::chrono::milliseconds;
using enum JobState;

class PgJobStoreTest : public test::JobStoreSteps {
 protected:
  // A process of its own, as the database sees it.
  struct Peer {
    explicit Peer(const std::string& url, std::function<int64_t()> now_ms,
                  milliseconds lease = milliseconds(60'000))
        : db(PgDatabase::open(url).value()),
          store(std::make_unique<PgJobStore>(*db, events, std::move(now_ms),
                                             PgOptions{true, lease})) {
      EXPECT_TRUE(store->recover().ok());
    }
    EventLog events;
    std::unique_ptr<PgDatabase> db;
    std::unique_ptr<PgJobStore> store;
  };

  void SetUp() override {
    server_ = qray::test::PostgresServer::instance();
    if (!server_) GTEST_SKIP() << qray::test::PostgresServer::why();
    url_ = server_->url(server_->new_schema());
    one_ = peer();
    store_ = one_->store.get();
  }
  std::unique_ptr<Peer> peer(milliseconds lease = milliseconds(60'000)) {
    return std::make_unique<Peer>(
        url_, [this] { return now_ms_.load(); }, lease);
  }
  void sql(const std::string& text) {
    PgDatabase::Session session(*one_->db);
    const Result<PgRows> done = session.run(text);
    ASSERT_TRUE(done.ok()) << done.error().text();
  }
  std::optional<JobRecord> claim(Peer& by, bool suspects = false) {
    Result<std::optional<JobRecord>> job = by.store->claim(suspects);
    EXPECT_TRUE(job.ok());
    return job.ok() ? std::move(job).value() : std::nullopt;
  }
  Result<JobRecord> move_as(Peer& by, const JobRecord& run, JobState to) {
    JobStore::Change change;
    change.claim = run.claim;
    return by.store->move(run.id, to, change);
  }

  qray::test::PostgresServer* server_ = nullptr;
  std::string url_;
  std::unique_ptr<Peer> one_;
};

TEST_F(PgJobStoreTest, AFailedWriteUndoesTheWholeMove) {
  const JobId id = insert();
  const uint64_t newest = one_->events.newest();
  sql("CREATE FUNCTION is_full() RETURNS trigger AS 'BEGIN RAISE EXCEPTION ''full''; END' LANGUAGE "
      "plpgsql");
  sql("CREATE TRIGGER is_full BEFORE INSERT ON tables FOR EACH ROW EXECUTE FUNCTION is_full()");
  JobStore::Change change;
  change.table = TableRow{};
  const Result<JobRecord> moved = store_->move(id, kPreparing, change);
  ASSERT_FALSE(moved.ok());
  EXPECT_NE(moved.error().text().find("full"), std::string::npos) << moved.error().text();
  EXPECT_EQ(get(id).state, kQueued);
  EXPECT_EQ(one_->events.newest(), newest);
  move(id, {kPreparing});  // and the store goes on
}

TEST_F(PgJobStoreTest, TheHighestPriorityIsClaimedFirstAndTheOldestOfOne) {
  JobRequest request;
  request.set(field::kScene, "box");
  std::vector<JobId> ids;
  for (const int priority : {0, 2, 0, 2}) {
    request.set(field::kPriority, priority);
    now_ms_ += 1000;
    ids.push_back(insert(request));
  }
  EXPECT_TRUE(store_->update(ids[2], [](JobRequest& r) { r.set(field::kPriority, 3); }).ok());
  for (const size_t next : {2, 1, 3, 0}) {
    const auto job = claim(*one_);
    ASSERT_TRUE(job);
    EXPECT_EQ(job->id, ids[next]);
    EXPECT_EQ(job->state, kPreparing);
    EXPECT_EQ(job->attempts, 1);
    EXPECT_EQ(get(job->id).claim, job->claim);
  }
  EXPECT_FALSE(claim(*one_));
}

TEST_F(PgJobStoreTest, ManyClaimersAndCancelersHaveEachJobOnce) {
  constexpr int kJobs = 120, kPeers = 4;
  for (int i = 0; i < kJobs; ++i) insert();
  std::mutex mutex;
  std::multiset<JobId> claimed, canceled;
  std::vector<std::thread> threads;
  for (int i = 0; i < kPeers; ++i)
    threads.emplace_back([&] {
      const auto peer = this->peer();
      while (const auto job = claim(*peer)) {
        EXPECT_TRUE(move_as(*peer, *job, kRendering).ok());
        EXPECT_TRUE(move_as(*peer, *job, kFailed).ok());
        std::lock_guard lock(mutex);
        claimed.insert(job->id);
      }
    });
  threads.emplace_back([&] {
    for (uint64_t id = kJobs; id > kJobs / 2; --id) {
      const Result<JobRecord> moved = store_->move({id}, kCanceled);
      EXPECT_TRUE(moved.ok() || moved.error().code == ErrorCode::kConflict) << moved.error().text();
      std::lock_guard lock(mutex);
      if (moved.ok()) canceled.insert({id});
    }
  });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(claimed.size() + canceled.size(), size_t{kJobs});
  EXPECT_EQ(std::set<JobId>(claimed.begin(), claimed.end()).size(), claimed.size());
  for (const JobId id : canceled) EXPECT_EQ(get(id).state, kCanceled);
}

TEST_F(PgJobStoreTest, AJobWhoseLeaseIsOverIsAnothers) {
  const auto sleeper = peer(milliseconds(30)), other = peer();
  insert();
  const JobRecord first = *claim(*sleeper);
  EXPECT_TRUE(move_as(*sleeper, first, kRendering).ok());
  const SharedJobs::Run run{first.id, first.claim, {0.5, 7, 2.5}};
  EXPECT_EQ(sleeper->store->renew({&run, 1}).value().size(), 1u);
  EXPECT_EQ(get(first.id).progress.samples, 7u);
  std::this_thread::sleep_for(milliseconds(40));
  EXPECT_TRUE(other->store->take_up_lost().ok());
  EXPECT_EQ(get(first.id).state, kQueued);
  // Nobody has it, but it is not the sleeper's: neither while it waits nor later.
  for (const JobState to : {kFinalizing, kFailed, kPaused, kCanceled, kQueued})
    EXPECT_EQ(move_as(*sleeper, first, to).error().code, ErrorCode::kConflict);
  EXPECT_TRUE(sleeper->store->renew({&run, 1}).value().empty());
  const JobRecord second = *claim(*other);
  EXPECT_GT(second.claim, first.claim);
  EXPECT_EQ(move_as(*sleeper, first, kRendering).error().code, ErrorCode::kConflict);
  EXPECT_TRUE(move_as(*other, second, kRendering).ok());
  EXPECT_EQ(get(first.id).attempts, 2);
}

TEST_F(PgJobStoreTest, AWorkerLearnsWhatOthersAskOfItsJobs) {
  insert();
  const JobRecord job = *claim(*one_);
  const auto front = peer();
  const SharedJobs::Run run{job.id, job.claim, {}};
  std::atomic<bool> told = false;
  std::thread waits([&] {
    one_->store->wait_for_news({}, milliseconds(20'000));
    told = true;
  });
  while (!told) {  // it may not wait yet
    (void)front->store->move(job.id, kPausing);
    (void)front->store->move(job.id, kCanceling);
    insert();
    std::this_thread::sleep_for(milliseconds(20));
  }
  waits.join();
  const auto held = one_->store->renew({&run, 1}).value();
  ASSERT_EQ(held.size(), 1u);
  EXPECT_EQ(held[0].state, kCanceling);
}

TEST_F(PgJobStoreTest, SuspectsRunOnlyWhereNothingElseDoes) {
  const JobId id = insert();
  for (int attempt = 1; attempt < kMaxAttempts; ++attempt) {
    const auto doomed = peer(milliseconds(0));
    ASSERT_TRUE(claim(*doomed));
    ASSERT_TRUE(one_->store->take_up_lost().ok());
  }
  EXPECT_FALSE(claim(*one_));
  const auto job = claim(*one_, /*suspects=*/true);
  ASSERT_TRUE(job);
  EXPECT_EQ(job->id, id);
}

TEST_F(PgJobStoreTest, AllSeeTheSameEventsUnderTheSameIds) {
  const auto other = peer();
  const uint64_t before = other->events.newest();
  std::vector<std::thread> threads;
  for (Peer* of : {one_.get(), other.get()})
    threads.emplace_back([of] {
      for (int i = 0; i < 40; ++i) {
        JobStore::Posted posted;
        posted.request.set(field::kScene, "box");
        const JobId id = of->store->insert({&posted, 1}, 1)[0].value().job.id;
        EXPECT_TRUE(of->store->move(id, kCanceled).ok());
        of->store->publish_hint({0, id.text(), "progress", "{}"});
      }
    });
  for (std::thread& thread : threads) thread.join();
  const auto seen = [&](const Peer& of) {
    std::vector<std::pair<uint64_t, std::string>> all;
    for (const Event& e : of.events.wait(before, "", milliseconds(0)).events)
      all.emplace_back(e.id, e.job + e.kind);
    return all;
  };
  constexpr size_t kAll = 80 * 4;  // queued, canceled, done, and the hint
  for (int i = 0; i < 200 && (seen(*one_).size() < kAll || seen(*other).size() < kAll); ++i)
    std::this_thread::sleep_for(milliseconds(20));
  EXPECT_EQ(seen(*one_).size(), kAll);
  EXPECT_EQ(seen(*one_), seen(*other));
}

TEST_F(PgJobStoreTest, EventsGoOnWhereTheOldestAreEmptied) {
  const JobId id = insert();
  for (const int64_t last : {24'998, 49'999, 99'995, 124'990}) {
    sql("SELECT setval('event_ids', " + std::to_string(last) + ")");
    for (int i = 0; i < 4; ++i) move(id, {kPreparing, kQueued});
    EXPECT_GE(one_->events.newest(), static_cast<uint64_t>(last) + 8);
  }
  PgDatabase::Session session(*one_->db);
  const auto oldest = session.run("SELECT min(id), count(*) FROM events");
  ASSERT_TRUE(oldest.ok());
  EXPECT_GT(oldest.value().integer(0, 0), 24'998);  // what was there before is gone
  EXPECT_GE(oldest.value().integer(0, 1), 16);
}

TEST_F(PgJobStoreTest, TwoFrontsThatAreGivenOneKeyMakeOneJob) {
  const auto other = peer();
  std::mutex mutex;
  std::map<std::string, std::set<JobId>> ids;
  std::vector<std::thread> threads;
  for (Peer* of : {one_.get(), other.get()})
    threads.emplace_back([&, of] {
      for (int round = 0; round < 20; ++round) {
        // In opposite orders, so that each would wait for the other if it could.
        std::vector<JobStore::Posted> posted(2);
        std::vector<std::string> keys{"a" + std::to_string(round), "b" + std::to_string(round)};
        if (of == other.get()) std::swap(keys[0], keys[1]);
        for (size_t i = 0; i < 2; ++i) {
          posted[i].request.set(field::kScene, "box");
          posted[i].key = {keys[i], "same"};
        }
        const auto made = of->store->insert(posted, 100);
        std::lock_guard lock(mutex);
        for (size_t i = 0; i < 2; ++i) {
          ASSERT_TRUE(made[i].ok()) << made[i].error().text();
          ids[keys[i]].insert(made[i].value().job.id);
        }
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(ids.size(), 40u);
  for (const auto& [key, of] : ids) EXPECT_EQ(of.size(), 1u) << key;
}

TEST_F(PgJobStoreTest, WhatWasAnsweredOutlivesTheDatabasesEnd) {
  std::vector<JobId> ids;
  for (int i = 0; i < 5; ++i) ids.push_back(insert());
  const JobRecord job = *claim(*one_);
  EXPECT_TRUE(move_as(*one_, job, kRendering).ok());
  const uint64_t newest = one_->events.newest();
  server_->stop_at_once();
  const Result<JobRecord> away = store_->get(ids[0]);
  ASSERT_FALSE(away.ok());
  EXPECT_EQ(away.error().code, ErrorCode::kIo);
  EXPECT_NE(away.error().text().find("PostgreSQL"), std::string::npos) << away.error().text();
  EXPECT_EQ(store_->move(ids[1], kCanceled).error().code, ErrorCode::kIo);
  server_->start();
  Status back = store_->try_writing();
  for (int i = 0; i < 100 && !back.ok(); ++i) {
    std::this_thread::sleep_for(milliseconds(50));
    back = store_->try_writing();
  }
  ASSERT_TRUE(back.ok()) << back.error().text();
  for (const JobId id : ids) EXPECT_EQ(get(id).state, id == job.id ? kRendering : kQueued);
  EXPECT_TRUE(move_as(*one_, job, kFinalizing).ok());
  EXPECT_GT(one_->events.newest(), newest);
  const auto fresh = peer();
  EXPECT_GT(fresh->events.newest(), newest);
}

TEST_F(PgJobStoreTest, ANewerSchemaAndAWrongAddressAreRefusedInWords) {
  sql("UPDATE qray_schema SET version=99");
  const auto newer = PgDatabase::open(url_);
  ASSERT_FALSE(newer.ok());
  EXPECT_EQ(newer.error().code, ErrorCode::kUnsupported);
  const auto nobody = PgDatabase::open("postgresql://u:secret@127.0.0.1:1/x");
  ASSERT_FALSE(nobody.ok());
  EXPECT_NE(nobody.error().text().find("cannot be reached"), std::string::npos);
  EXPECT_NE(nobody.error().text().find("127.0.0.1"), std::string::npos);
  EXPECT_EQ(nobody.error().text().find("secret"), std::string::npos) << nobody.error().text();
}

TEST_F(PgJobStoreTest, ADamagedRowIsAFailedJobAndHarmsNoOther) {
  const JobId queued = insert(), ended = insert(), whole = insert();
  move(ended, {kPreparing, kRendering, kFinalizing, kSucceeded});
  sql("UPDATE jobs SET request='{\"scene\":' WHERE id=" + std::to_string(queued.value));
  sql("UPDATE jobs SET state='dreaming' WHERE id=" + std::to_string(ended.value));
  const auto fresh = peer();
  EXPECT_EQ(get(queued).state, kFailed);
  EXPECT_EQ(get(ended).state, kFailed);
  EXPECT_TRUE(get(ended).damaged);
  EXPECT_EQ(claim(*fresh)->id, whole);
  EXPECT_FALSE(claim(*fresh));
  EXPECT_FALSE(store_->move(queued, kQueued).ok());
}

}  // namespace
}  // namespace qray::server
#endif
