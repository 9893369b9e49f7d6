// Units of a pass, as several processes take and bring them: each once, under the claim of the run
// that owns them.
#ifdef QRAY_POSTGRES
#include "server/postgres/pg_shared_passes.h"

#include <gtest/gtest.h>

#include <set>
#include <thread>

#include "server/postgres/pg_job_store.h"
#include "tests/server/store/job_store_steps.h"
#include "tests/support/postgres_server.h"

namespace qray::server {
namespace {

using Put = SharedPasses::Put;

class PgSharedPassesTest : public test::JobStoreSteps {
 protected:
  struct Peer {
    Peer(const std::string& url, const std::function<int64_t()>& now_ms)
        : db(PgDatabase::open(url).value()),
          store(*db, events, now_ms, PgOptions{true, std::chrono::minutes(1)}),
          passes(*db, store.worker()) {
      EXPECT_TRUE(store.recover().ok());
    }
    EventLog events;
    std::unique_ptr<PgDatabase> db;
    PgJobStore store;
    PgSharedPasses passes;
  };

  void SetUp() override {
    server_ = qray::test::PostgresServer::instance();
    if (!server_) GTEST_SKIP() << qray::test::PostgresServer::why();
    url_ = server_->url(server_->new_schema());
    for (auto* peer : {&owner_, &one_, &other_})
      *peer = std::make_unique<Peer>(url_, [this] { return now_ms_.load(); });
    store_ = &owner_->store;
    insert();
    const JobRecord job = *owner_->store.claim(false).value();
    pass_.key = {job.id, job.claim, 1};
    pass_.cut = {0, 10, 4};
    pass_.patience = 60;
    pass_.state = {0, 1, 2, 0};
    pass_.guide = "a hash";
    open_ = {job.id, job.claim};
  }
  void begin(int workers = 0) {
    const Bytes guide = {7, 0, 9};
    ASSERT_TRUE(owner_->passes.begin(pass_, "bits", workers, &guide).ok());
  }
  std::optional<size_t> take(Peer& by, double patience = 60) {
    return by.passes.take(pass_.key, patience).value();
  }
  Put put(Peer& by, size_t unit, const std::string& hash, const SharedPasses::Key& key) {
    return by.passes.put(key, {unit, by.passes.me(), hash, {1, 0, 3}}).value();
  }
  Put put(Peer& by, size_t unit, const std::string& hash) { return put(by, unit, hash, pass_.key); }

  qray::test::PostgresServer* server_ = nullptr;
  std::string url_;
  std::unique_ptr<Peer> owner_, one_, other_;
  SharedPasses::Pass pass_;
  SharedPasses::Open open_;
};

TEST_F(PgSharedPassesTest, UnitsAreTakenOnceAndBroughtBack) {
  EXPECT_EQ(pass_.cut.units(), 3u);
  EXPECT_EQ(pass_.cut.tiles_of(2), 2u);
  EXPECT_FALSE(one_->passes.find("bits").value());
  begin();
  EXPECT_FALSE(one_->passes.find("other bits").value());
  EXPECT_FALSE(owner_->passes.find("bits").value()) << "its own";
  ASSERT_TRUE(one_->passes.find("bits").value());
  ASSERT_TRUE(one_->passes.join(open_).value());
  const auto pass = one_->passes.next(open_, std::nullopt).value();
  ASSERT_TRUE(pass);
  EXPECT_EQ(pass->key, pass_.key);
  EXPECT_EQ(pass->state, pass_.state);
  EXPECT_EQ(pass->cut.units(), 3u);
  EXPECT_FALSE(one_->passes.next(open_, pass->key).value()) << "no other";
  EXPECT_EQ(one_->passes.load_guide(open_, "a hash").value(), (Bytes{7, 0, 9}));
  EXPECT_FALSE(one_->passes.load_guide(open_, "another").ok());
  std::set<size_t> units;
  for (Peer* by : {one_.get(), owner_.get(), other_.get()}) units.insert(*take(*by));
  EXPECT_EQ(units, (std::set<size_t>{0, 1, 2}));
  EXPECT_FALSE(take(*one_));
  EXPECT_EQ(put(*one_, 0, "h0"), Put::kTaken);
  EXPECT_EQ(put(*owner_, 1, "h1"), Put::kTaken);
  const auto collected = owner_->passes.collect(pass_.key, {}).value();
  ASSERT_EQ(collected.units.size(), 1u) << "what others brought";
  EXPECT_EQ(collected.units[0].worker, one_->passes.me());
  EXPECT_EQ(collected.units[0].sampled, (Bytes{1, 0, 3}));
  const size_t here[] = {0};
  EXPECT_TRUE(owner_->passes.collect(pass_.key, here).value().units.empty());
}

TEST_F(PgSharedPassesTest, ASlowOnesUnitIsGivenToAnotherAndDifferencesAreTold) {
  begin();
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(take(*one_));
  EXPECT_FALSE(take(*other_));
  EXPECT_EQ(take(*other_, /*patience=*/0), 0u);
  EXPECT_EQ(put(*other_, 0, "h"), Put::kTaken);
  EXPECT_EQ(put(*one_, 0, "h"), Put::kTwice);
  EXPECT_TRUE(owner_->passes.collect(pass_.key, {}).value().disputed.empty());
  EXPECT_EQ(put(*one_, 0, "another"), Put::kDiffers);
  const auto collected = owner_->passes.collect(pass_.key, {}).value();
  ASSERT_EQ(collected.units.size(), 1u);
  EXPECT_EQ(collected.units[0].hash, "h") << "the first one counts";
  ASSERT_EQ(collected.disputed.size(), 2u);
  EXPECT_EQ(collected.disputed[0].worker, one_->passes.me());
  EXPECT_EQ(collected.disputed[1].worker, other_->passes.me());
  const size_t units[] = {0};
  ASSERT_TRUE(owner_->passes.reopen(pass_.key, units).ok());
  EXPECT_EQ(take(*owner_), 0u);
}

TEST_F(PgSharedPassesTest, WhatComesTooLateIsRefused) {
  begin();
  const SharedPasses::Key before = pass_.key;
  ++pass_.key.pass;
  begin();
  EXPECT_EQ(put(*one_, 0, "h", before), Put::kLate);
  EXPECT_FALSE(owner_->passes.collect(before, {}).value().there);
  EXPECT_FALSE(one_->passes.take(before, 0).value());
  ASSERT_TRUE(take(*one_));
  EXPECT_EQ(put(*one_, 0, "h"), Put::kTaken);
  // The run has lost the job: what it does changes nothing for the one that has it.
  SharedPasses::Pass zombie = pass_;
  ++zombie.key.claim;
  EXPECT_EQ(owner_->passes.begin(zombie, "bits", 0, nullptr).error().code, ErrorCode::kCanceled);
  EXPECT_EQ(other_->passes.begin(pass_, "bits", 0, nullptr).error().code, ErrorCode::kCanceled);
  EXPECT_EQ(owner_->passes.collect(pass_.key, {}).value().units.size(), 1u);
  EXPECT_EQ(take(*other_), 1u);
  ASSERT_TRUE(owner_->passes.end(open_.job, open_.claim).ok());
  EXPECT_FALSE(one_->passes.find("bits").value());
  EXPECT_FALSE(one_->passes.join(open_).value());
  EXPECT_EQ(put(*one_, 0, "h"), Put::kLate);
}

TEST_F(PgSharedPassesTest, NoMoreTakePartThanAreWanted) {
  begin(/*workers=*/2);
  EXPECT_TRUE(one_->passes.join(open_).value());
  EXPECT_TRUE(one_->passes.join(open_).value()) << "the same one again";
  EXPECT_FALSE(other_->passes.find("bits").value());
  EXPECT_FALSE(other_->passes.join(open_).value());
  ASSERT_TRUE(one_->passes.leave(open_).ok());
  EXPECT_TRUE(other_->passes.join(open_).value());
}

TEST_F(PgSharedPassesTest, WhoIsPutAsideTakesNoPart) {
  begin();
  WorkerInfo info;
  info.threads = 1;
  info.bits = "bits";
  ASSERT_TRUE(one_->store.present(info).value());
  ASSERT_TRUE(owner_->passes.put_aside(one_->passes.me(), "why").ok());
  EXPECT_FALSE(one_->store.present(info).value()) << "it is to take no more jobs";
  EXPECT_FALSE(one_->passes.find("bits").value());
  EXPECT_EQ(owner_->store.workers().value()[0].aside, "why");
  EXPECT_EQ(owner_->passes.others_of_other_bits("bits").value(), 0);
  EXPECT_EQ(owner_->passes.others_of_other_bits("other bits").value(), 1);
}

TEST_F(PgSharedPassesTest, ADatabaseThatLostItsPowerHasLostThePassAndNothingElse) {
  begin();
  ASSERT_TRUE(take(*one_));
  server_->stop_at_once();
  EXPECT_FALSE(owner_->passes.collect(pass_.key, {}).ok());
  server_->start();
  // Whoever still has a connection from before is told so once.
  const auto at_last = [](const auto& call) {
    auto answer = call();
    for (int i = 0; i < 100 && !answer.ok(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      answer = call();
    }
    return answer;
  };
  const auto collected = at_last([&] { return owner_->passes.collect(pass_.key, {}); });
  ASSERT_TRUE(collected.ok());
  EXPECT_FALSE(collected.value().there);
  ++pass_.key.pass;
  ASSERT_TRUE(at_last([&] { return owner_->passes.begin(pass_, "bits", 0, nullptr); }).ok());
  const auto taken = at_last([&] { return one_->passes.take(pass_.key, 60); });
  ASSERT_TRUE(taken.ok());
  EXPECT_EQ(taken.value(), 0u);
}

}  // namespace
}  // namespace qray::server
#endif
