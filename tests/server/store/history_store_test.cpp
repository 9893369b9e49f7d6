#include "server/store/history_store.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/scratch.h"

namespace qray::server {
namespace {

namespace fs = std::filesystem;

class HistoryStoreTest : public ::testing::Test {
 protected:
  Status add(JobId id, uint32_t number, uint64_t samples, const Bytes& picture = {},
             const Bytes& table = {}) {
    proto::Moment moment;
    moment.number = number;
    moment.samples = samples;
    moment.gate = "on";
    moment.picture = !picture.empty();
    moment.table = !table.empty();
    return store_->add(id, moment, picture, table);
  }
  std::vector<uint64_t> samples(JobId id) const {
    std::vector<uint64_t> samples;
    for (const proto::Moment& moment : store_->moments(id)) {
      EXPECT_EQ(moment.gate, "on");
      samples.push_back(moment.samples);
    }
    return samples;
  }
  void open(uint64_t max_bytes = 100'000) {
    store_ = std::make_unique<HistoryStore>(scratch_.path(), max_bytes);
  }
  fs::path file(JobId id) const { return scratch_ / "history" / id.text(); }
  void SetUp() override { open(); }

  qray::test::ScratchFolder scratch_;
  std::unique_ptr<HistoryStore> store_;
};

using Numbers = std::vector<uint64_t>;

TEST_F(HistoryStoreTest, KeepsMomentsWithTheirPicturesAndTables) {
  EXPECT_TRUE(samples({1}).empty());
  EXPECT_EQ(store_->picture({1}, 1).error().code, ErrorCode::kNotFound);
  ASSERT_TRUE(add({1}, 1, 1, Bytes(50, 7)).ok());
  ASSERT_TRUE(add({1}, 2, 3, Bytes(60, 8), Bytes(70, 9)).ok());
  ASSERT_TRUE(add({1}, 3, 6).ok());
  EXPECT_EQ(samples({1}), (Numbers{1, 3, 6}));
  EXPECT_EQ(store_->picture({1}, 2).value(), Bytes(60, 8));
  EXPECT_EQ(store_->table({1}, 2).value(), Bytes(70, 9));
  EXPECT_FALSE(store_->table({1}, 1).ok());
  EXPECT_FALSE(store_->picture({1}, 3).ok());
  open();
  EXPECT_EQ(samples({1}), (Numbers{1, 3, 6}));
  store_->remove({1});
  EXPECT_TRUE(samples({1}).empty());
}

TEST_F(HistoryStoreTest, ARunThatWentBackTakesThePlaceOfWhatWasCutOff) {
  for (uint32_t n = 1; n <= 4; ++n) ASSERT_TRUE(add({1}, n, n, Bytes(10, uint8_t(n))).ok());
  ASSERT_TRUE(add({1}, 3, 30, Bytes(10, 33)).ok());
  EXPECT_EQ(samples({1}), (Numbers{1, 2, 30}));
  EXPECT_EQ(store_->picture({1}, 3).value(), Bytes(10, 33));
}

TEST_F(HistoryStoreTest, GoesOnBehindWhatAKillCutOff) {
  ASSERT_TRUE(add({1}, 1, 1, Bytes(50, 7)).ok());
  const uint64_t whole = fs::file_size(file({1}));
  ASSERT_TRUE(add({1}, 2, 3, Bytes(500, 8)).ok());
  for (const uint64_t size : {whole + 1, whole + 19, whole + 20, whole + 300}) {
    fs::resize_file(file({1}), size);
    open();
    EXPECT_EQ(samples({1}), (Numbers{1})) << size;
    ASSERT_TRUE(add({1}, 2, 3, Bytes(500, 8)).ok());
    EXPECT_EQ(samples({1}), (Numbers{1, 3})) << size;
    EXPECT_EQ(store_->picture({1}, 2).value(), Bytes(500, 8)) << size;
  }
}

TEST_F(HistoryStoreTest, ChangedBytesAreNotGivenOut) {
  ASSERT_TRUE(add({1}, 1, 1, Bytes(50, 7)).ok());
  ASSERT_TRUE(add({1}, 2, 2).ok());
  {
    std::fstream changed(file({1}), std::ios::in | std::ios::out | std::ios::binary);
    changed.seekp(40);  // within the picture
    changed.put('x');
  }
  EXPECT_EQ(store_->picture({1}, 1).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(samples({1}), (Numbers{1, 2}));
  std::ofstream(file({1}), std::ios::binary) << "something else";
  EXPECT_TRUE(samples({1}).empty());
  open();
  ASSERT_TRUE(add({1}, 1, 5).ok());
  EXPECT_EQ(samples({1}), (Numbers{5}));
}

TEST_F(HistoryStoreTest, TheOldestJobsMakeRoom) {
  open(3000);
  for (uint64_t id = 1; id <= 4; ++id) ASSERT_TRUE(add({id}, 1, id, Bytes(1000, 1)).ok());
  EXPECT_TRUE(samples({1}).empty());
  EXPECT_TRUE(samples({2}).empty());
  EXPECT_EQ(samples({4}), (Numbers{4}));
  open(3000);  // counts what is there
  ASSERT_TRUE(add({5}, 1, 5, Bytes(1000, 1)).ok());
  EXPECT_TRUE(samples({3}).empty());
  ASSERT_TRUE(add({6}, 1, 6, Bytes(9000, 1)).ok());  // more than all: the others go, it stays
  EXPECT_EQ(samples({6}), (Numbers{6}));
  EXPECT_TRUE(samples({5}).empty());
}

TEST_F(HistoryStoreTest, AFolderThatCannotBeWrittenIsAnError) {
  std::ofstream(scratch_ / "history") << "in the way";
  EXPECT_EQ(add({1}, 1, 1).error().code, ErrorCode::kIo);
}

}  // namespace
}  // namespace qray::server
