#include "server/store/moment_store.h"

#include <gtest/gtest.h>

#include <fstream>

#include "core/base/file.h"
#include "tests/support/scratch.h"

namespace qray::server {
namespace {

namespace fs = std::filesystem;

class MomentStoreTest : public ::testing::Test {
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
    store_ = std::make_unique<MomentStore>(scratch_.path(), max_bytes);
  }
  fs::path file(JobId id) const { return scratch_ / "moments" / id.text(); }
  void SetUp() override { open(); }

  qray::test::ScratchFolder scratch_;
  std::unique_ptr<MomentStore> store_;
};

using Numbers = std::vector<uint64_t>;

TEST_F(MomentStoreTest, KeepsMomentsWithTheirPicturesAndTables) {
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

TEST_F(MomentStoreTest, ARunThatWentBackTakesThePlaceOfWhatWasCutOff) {
  for (uint32_t n = 1; n <= 4; ++n) ASSERT_TRUE(add({1}, n, n, Bytes(10, uint8_t(n))).ok());
  ASSERT_TRUE(add({1}, 3, 30, Bytes(10, 33)).ok());
  EXPECT_EQ(samples({1}), (Numbers{1, 2, 30}));
  EXPECT_EQ(store_->picture({1}, 3).value(), Bytes(10, 33));
}

TEST_F(MomentStoreTest, GoesOnBehindWhatAKillCutOff) {
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

TEST_F(MomentStoreTest, ChangedBytesAreNotGivenOut) {
  ASSERT_TRUE(add({1}, 1, 1, Bytes(50, 7)).ok());
  ASSERT_TRUE(add({1}, 2, 2).ok());
  {
    std::fstream changed(file({1}), std::ios::in | std::ios::out | std::ios::binary);
    changed.seekp(50);  // within the picture
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

TEST_F(MomentStoreTest, EveryMemberOfAMomentIsKept) {
  proto::Moment moment;
  moment.number = 3;
  moment.samples = uint64_t{1} << 40;
  moment.seconds = 1.5;
  moment.noise = 0.25;
  moment.learning = true;
  moment.efficiency_gain = 1.75;
  moment.states = 11;
  moment.direction_nodes = 12;
  moment.table_bytes = 13;
  moment.gate = "off: it cost more than it saved";
  moment.table = true;
  ASSERT_TRUE(store_->add({1}, moment, {}, Bytes(1)).ok());
  const std::vector<proto::Moment> all = store_->moments({1});
  ASSERT_EQ(all.size(), 1u);
  const proto::Moment& back = all[0];
  EXPECT_EQ(back.number, moment.number);
  EXPECT_EQ(back.samples, moment.samples);
  EXPECT_EQ(back.seconds, moment.seconds);
  EXPECT_EQ(back.noise, moment.noise);
  EXPECT_EQ(back.efficiency_gain, moment.efficiency_gain);
  EXPECT_TRUE(back.learning && back.table && !back.guided && !back.picture);
  EXPECT_EQ(back.states, moment.states);
  EXPECT_EQ(back.direction_nodes, moment.direction_nodes);
  EXPECT_EQ(back.table_bytes, moment.table_bytes);
  EXPECT_EQ(back.gate, moment.gate);
}

// Whoever changes these raises the version in moment_store.cpp.
TEST_F(MomentStoreTest, BytesOnPaper) {
  ASSERT_TRUE(add({1}, 2, 3, Bytes{5, 6}).ok());
  ByteWriter moment;
  moment.u32(2);
  moment.u64(3);
  for (int i = 0; i < 3; ++i) moment.f64(0);  // seconds, noise, efficiency gain
  moment.bytes(Bytes{0, 0, 1, 0});            // learning, guided, picture, table
  for (int i = 0; i < 3; ++i) moment.u64(0);  // states, nodes, bytes
  moment.string("on");
  ByteWriter expected;
  expected.u64(0x53544d4f4d594152);  // "RAYMOMTS"
  expected.u32(1);
  for (const auto& [kind, payload] : {std::pair{2u, Bytes{5, 6}}, {1u, moment.data()}}) {
    ByteWriter head;
    head.u32(kind);
    head.u32(2);  // the moment's number
    head.u64(payload.size());
    expected.bytes(head.data());
    expected.u32(crc32c(payload, crc32c(head.data())));
    expected.bytes(payload);
  }
  EXPECT_EQ(read_file(file({1}), 1 << 20).value(), expected.data());
}

// No bit can be turned without its record, or the whole file, being left out.
TEST_F(MomentStoreTest, AnyChangedByteIsNoticed) {
  ASSERT_TRUE(add({1}, 1, 4, Bytes(20, 7), Bytes(20, 8)).ok());
  const Bytes good = read_file(file({1}), 1 << 20).value();
  for (size_t at = 0; at < good.size(); ++at) {
    Bytes bad = good;
    bad[at] ^= 0x11;
    ASSERT_TRUE(write_file_atomic(file({1}), bad).ok());
    const bool all =
        store_->picture({1}, 1).ok() && store_->table({1}, 1).ok() && !store_->moments({1}).empty();
    EXPECT_FALSE(all) << at;
    for (const Result<Bytes>& kept : {store_->picture({1}, 1), store_->table({1}, 1)})
      EXPECT_TRUE(!kept.ok() || kept.value() == Bytes(20, 7) || kept.value() == Bytes(20, 8)) << at;
  }
}

TEST_F(MomentStoreTest, WhatAnotherVersionKeptIsRemovedAndTold) {
  for (uint64_t id : {1u, 2u}) ASSERT_TRUE(add({id}, 1, 1).ok());
  Bytes other = read_file(file({2}), 1 << 20).value();
  other[8] = 99;  // its version
  ASSERT_TRUE(write_file_atomic(file({2}), other).ok());
  EXPECT_TRUE(samples({2}).empty());
  const fs::path old = scratch_ / "history";
  fs::create_directories(old);
  std::ofstream(old / JobId{3}.text()) << "RAYHIST1 and memory";
  open();
  std::vector<JobId> told = store_->remove_others();
  EXPECT_EQ(told, (std::vector<JobId>{{2}, {3}}));
  EXPECT_FALSE(fs::exists(old));
  EXPECT_FALSE(fs::exists(file({2})));
  EXPECT_EQ(samples({1}), (Numbers{1}));
  EXPECT_TRUE(store_->remove_others().empty());
}

TEST_F(MomentStoreTest, TheOldestJobsMakeRoom) {
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

TEST_F(MomentStoreTest, AFolderThatCannotBeWrittenIsAnError) {
  std::ofstream(scratch_ / "moments") << "in the way";
  EXPECT_EQ(add({1}, 1, 1).error().code, ErrorCode::kIo);
}

}  // namespace
}  // namespace qray::server
