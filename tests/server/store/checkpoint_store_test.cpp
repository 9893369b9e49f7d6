#include "server/store/checkpoint_store.h"

#include <gtest/gtest.h>

#include "core/base/file.h"
#include "tests/support/scratch.h"

namespace qray::server {
namespace {

namespace fs = std::filesystem;

const StateOrigin kHere{2, 5, "here"};

class CheckpointStoreTest : public ::testing::Test {
 protected:
  Status save(JobId id, int number, size_t bytes = 100) {
    return save_by(store_, id, number, bytes);
  }
  static Status save_by(CheckpointStore& store, JobId id, int number, size_t bytes = 100) {
    return store.save(id, {"hash", "table", "net", {"a", "b"}, true},
                      [&](SnapshotWriter& out) { out(number, std::vector<uint8_t>(bytes)); });
  }
  int load(JobId id) {
    const Result<Checkpoint> checkpoint = store_.load(id);
    if (!checkpoint.ok()) return -1;
    EXPECT_EQ(checkpoint.value().header.scene_hash, "hash");
    EXPECT_EQ(checkpoint.value().header.warnings.size(), 2u);
    EXPECT_TRUE(checkpoint.value().header.mixed_builds);
    EXPECT_FALSE(checkpoint.value().other_build);
    SnapshotReader in = checkpoint.value().state();
    int number = 0;
    std::vector<uint8_t> bytes;
    in(number, bytes);
    EXPECT_TRUE(in.whole());
    return number;
  }
  fs::path file(JobId id) const { return scratch_ / "checkpoints" / id.text(); }

  qray::test::ScratchFolder scratch_;
  CheckpointStore store_{scratch_.path(), 10'000, kHere};
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

// A frame's two last turns, until its job's state goes.
TEST_F(CheckpointStoreTest, FramesAreKeptBesideTheirJob) {
  const auto frames = [&](JobId id) {
    return fs::exists(scratch_ / "checkpoints" / (id.text() + ".frames"));
  };
  const auto save_frame = [&](JobId id, int frame, int turn, size_t bytes) {
    return store_.save_frame(
        id, frame, turn,
        [&](SnapshotWriter& out) { out(100 * frame + turn, std::vector<uint8_t>(bytes)); }, {});
  };
  const auto load_frame = [&](JobId id, int frame, int turn) {
    const Result<Checkpoint> kept = store_.load_frame(id, frame, turn);
    int number = -1;
    if (kept.ok()) {
      SnapshotReader in = kept.value().state();
      in(number);
    }
    return number;
  };
  for (const JobId id : {JobId{1}, JobId{2}, JobId{3}}) ASSERT_TRUE(save(id, 5).ok());
  for (int turn = 1; turn <= 3; ++turn) ASSERT_TRUE(save_frame({1}, 4, turn, 100).ok());
  EXPECT_EQ(load_frame({1}, 4, 2), 402);
  EXPECT_EQ(load_frame({1}, 4, 3), 403);
  EXPECT_EQ(load_frame({1}, 5, 1), -1);
  store_.remove({1});
  EXPECT_FALSE(frames({1}));
  // They count as their job's bytes: of 10,000 that finished jobs may have.
  ASSERT_TRUE(save_frame({2}, 0, 1, 9'000).ok());
  ASSERT_TRUE(save_frame({3}, 0, 1, 9'000).ok());
  store_.finished({2});
  EXPECT_TRUE(frames({2}));
  store_.finished({3});
  EXPECT_FALSE(frames({2}) || store_.has({2}));
  EXPECT_TRUE(frames({3}) && store_.has({3}));
  store_.tidy([](JobId) { return CheckpointStore::Keep::kNo; });
  EXPECT_FALSE(frames({3}) || store_.has({3}));
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

// Whose state a build may go on from: one of its own format and revision.
TEST_F(CheckpointStoreTest, AStateOfAnotherBuildIsSaidOrRefused) {
  const auto written_by = [&](const StateOrigin& origin) {
    CheckpointStore store(scratch_.path(), 10'000, origin);
    EXPECT_TRUE(save_by(store, {1}, 10).ok());
    return store_.load({1});
  };
  const Result<Checkpoint> same = written_by(kHere);
  ASSERT_TRUE(same.ok());
  EXPECT_FALSE(same.value().other_build);

  const Result<Checkpoint> other = written_by({2, 5, "there"});
  ASSERT_TRUE(other.ok()) << other.error().text();
  EXPECT_TRUE(other.value().other_build);
  EXPECT_EQ(other.value().header.scene_hash, "hash");

  for (const auto& [origin, why] : {std::pair{StateOrigin{2, 6, "here"}, "revision 6, here 5"},
                                    {StateOrigin{1, 5, "here"}, "is of format 1"},
                                    {StateOrigin{3, 5, "here"}, "is of format 3"}}) {
    const Result<Checkpoint> refused = written_by(origin);
    ASSERT_FALSE(refused.ok()) << why;
    EXPECT_EQ(refused.error().code, ErrorCode::kUnsupported);
    EXPECT_NE(refused.error().text().find(why), std::string::npos) << refused.error().text();
  }
}

// As the builds before formats were told apart wrote it: memory behind a version that stayed 1.
TEST_F(CheckpointStoreTest, AStateOfRawMemoryIsRefused) {
  fs::create_directories(scratch_ / "checkpoints");
  ByteWriter old;
  old.u64(0x31504b4359415251);
  old.u32(1);
  old.u64(5);
  old.bytes(Bytes{'0', '.', '1', '.', '0'});
  old.bytes(Bytes(300, 1));
  old.u32(crc32c(old.data()));
  ASSERT_TRUE(write_file_atomic(file({1}), old.data()).ok());
  EXPECT_EQ(store_.load({1}).error().code, ErrorCode::kUnsupported);
}

TEST_F(CheckpointStoreTest, BytesOnPaper) {
  ASSERT_TRUE(
      store_.save({1}, {"h", "", "", {}, false}, [](SnapshotWriter& out) { out(uint8_t{7}); })
          .ok());
  ByteWriter expected;
  expected.u64(0x31504b4359415251);  // "QRAYCKP1"
  expected.u32(2);
  expected.u32(5);
  expected.string("here");
  expected.bytes(Bytes{4, 1, 0, 0, 0, 0, 0, 0, 0, 'h'});  // texts
  for (int text = 0; text < 2; ++text) expected.bytes(Bytes{4, 0, 0, 0, 0, 0, 0, 0, 0});
  expected.bytes(Bytes{3, 0, 0, 0, 0, 0, 0, 0, 0});  // a list
  expected.bytes(Bytes{0x11, 0});
  expected.bytes(Bytes{0x41, 7});
  expected.u32(crc32c(expected.data()));
  EXPECT_EQ(read_file(file({1}), 1 << 20).value(), expected.data());
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
