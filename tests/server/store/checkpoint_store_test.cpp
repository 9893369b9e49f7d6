#include "server/store/checkpoint_store.h"

#include <gtest/gtest.h>

#include "core/base/file.h"
#include "tests/support/scratch.h"

namespace qray::server {
namespace {

namespace fs = std::filesystem;

class CheckpointStoreTest : public ::testing::Test {
 protected:
  Status save(JobId id, int number, size_t bytes = 100) {
    return store_.save(id, {"hash", "table", "net", {"a", "b"}},
                       [&](SnapshotWriter& out) { out(number, std::vector<uint8_t>(bytes)); });
  }
  int load(JobId id) {
    const Result<Checkpoint> checkpoint = store_.load(id);
    if (!checkpoint.ok()) return -1;
    EXPECT_EQ(checkpoint.value().header.scene_hash, "hash");
    EXPECT_EQ(checkpoint.value().header.warnings.size(), 2u);
    SnapshotReader in = checkpoint.value().state();
    int number = 0;
    std::vector<uint8_t> bytes;
    in(number, bytes);
    EXPECT_TRUE(in.whole());
    return number;
  }
  fs::path file(JobId id) const { return scratch_ / "checkpoints" / id.text(); }

  qray::test::ScratchFolder scratch_;
  CheckpointStore store_{scratch_.path(), 10'000};
};

TEST_F(CheckpointStoreTest, KeepsTheLast) {
  EXPECT_FALSE(store_.has({1}));
  EXPECT_EQ(store_.load({1}).error().code, ErrorCode::kNotFound);
  ASSERT_TRUE(save({1}, 10).ok());
  ASSERT_TRUE(save({1}, 20, 200'000).ok());
  ASSERT_TRUE(save({2}, 30).ok());
  EXPECT_EQ(load({1}), 20);
  EXPECT_EQ(load({2}), 30);
  store_.remove({1});
  EXPECT_FALSE(store_.has({1}));
  EXPECT_EQ(load({2}), 30);
}

TEST_F(CheckpointStoreTest, WhatIsTornOrChangedIsRefused) {
  ASSERT_TRUE(save({1}, 10).ok());
  const Bytes good = read_file(file({1}), 1 << 20).value();
  for (size_t at = 0; at < good.size(); at += 7) {
    Bytes bad = good;
    bad[at] ^= 0x40;
    ASSERT_TRUE(write_file_atomic(file({1}), bad).ok());
    EXPECT_EQ(load({1}), -1) << at;
    bad.resize(at);
    ASSERT_TRUE(write_file_atomic(file({1}), bad).ok());
    EXPECT_EQ(load({1}), -1) << at;
  }
}

TEST_F(CheckpointStoreTest, TheOldestFinishedMakeRoom) {
  for (unsigned id : {1u, 2u, 3u}) {
    ASSERT_TRUE(save({id}, 1, 4000).ok());
    store_.finished({id});
  }
  EXPECT_FALSE(store_.has({1}));
  EXPECT_TRUE(store_.has({2}) && store_.has({3}));
  ASSERT_TRUE(save({9}, 1, 50'000).ok());  // of a job that runs: it counts for itself
  EXPECT_TRUE(store_.has({2}) && store_.has({3}));
}

TEST_F(CheckpointStoreTest, AStartRemovesWhatIsNoJobsAnyMore) {
  for (unsigned id : {1u, 2u, 3u}) ASSERT_TRUE(save({id}, 1, 4000).ok());
  ASSERT_TRUE(write_file_atomic(scratch_ / "checkpoints" / "j000002.tmp.1.1", Bytes(10)).ok());
  store_.tidy([](JobId id) {
    using enum CheckpointStore::Keep;
    return id == JobId{1} ? kNo : id == JobId{2} ? kOpen : kFinished;
  });
  EXPECT_FALSE(store_.has({1}));
  EXPECT_TRUE(store_.has({2}) && store_.has({3}));
  EXPECT_FALSE(fs::exists(scratch_ / "checkpoints" / "j000002.tmp.1.1"));
}

TEST_F(CheckpointStoreTest, AFolderThatCannotBeWrittenIsAnError) {
  ASSERT_TRUE(write_file_atomic(scratch_ / "checkpoints", Bytes(1)).ok());  // a file in its place
  EXPECT_EQ(save({1}, 1).error().code, ErrorCode::kIo);
}

}  // namespace
}  // namespace qray::server
