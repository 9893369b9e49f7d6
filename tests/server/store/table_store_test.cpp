#include "server/store/table_store.h"

#include <gtest/gtest.h>

#include "core/base/file.h"
#include "server/sqlite/sqlite_table_index.h"
#include "tests/support/scratch.h"

namespace qray::server {
namespace {

namespace fs = std::filesystem;

TableFile table(char digit, uint8_t scene = 0) {
  TableFile t;
  t.header.id = std::string(32, digit);
  t.header.method = "huang";
  t.header.program = "test";
  t.header.geometry.bytes[0] = scene;
  t.sections.push_back({"TEST", {1, 2, 3}});
  return t;
}

SceneHash scene(uint8_t geometry) {
  SceneHash hash;
  hash.geometry.bytes[0] = geometry;
  return hash;
}

class TableStoreTest : public ::testing::Test {
 protected:
  void SetUp() override {
    Result<std::unique_ptr<Database>> db = Database::open(scratch_ / "t.sqlite");
    ASSERT_TRUE(db.ok());
    db_ = std::move(db).value();
    index_ = std::make_unique<SqliteTableIndex>(*db_);
    Result<std::unique_ptr<TableStore>> store = TableStore::open(*index_, scratch_.path());
    ASSERT_TRUE(store.ok());
    store_ = std::move(store).value();
  }
  void add(const TableFile& t, uint64_t samples_seen = 8) {
    const Status added = store_->add(
        t, {t.header.id, "box", t.header.method, {"p", "q"}, 5, 0, 7, samples_seen, "j000001"});
    ASSERT_TRUE(added.ok());
  }
  std::vector<std::string> fitting(uint8_t geometry, size_t limit = 8) {
    const auto ids = store_->fitting("huang", scene(geometry), limit);
    EXPECT_TRUE(ids.ok());
    return ids.value();
  }

  qray::test::ScratchFolder scratch_;
  std::unique_ptr<Database> db_;
  std::unique_ptr<TableIndex> index_;
  std::unique_ptr<TableStore> store_;
};

TEST_F(TableStoreTest, KeepsFileAndRecord) {
  add(table('a'));
  const Result<TableFile> loaded = store_->load(std::string(32, 'a'));
  ASSERT_TRUE(loaded.ok()) << loaded.error().text();
  EXPECT_EQ(loaded.value().sections[0].bytes, (Bytes{1, 2, 3}));
  const Result<proto::TableInfo> info = store_->find(std::string(32, 'a'));
  ASSERT_TRUE(info.ok());
  EXPECT_EQ(info.value().parents, (std::vector<std::string>{"p", "q"}));
  EXPECT_EQ(info.value().bytes, fs::file_size(scratch_ / ("tables/" + info.value().id + ".qrt")));
  EXPECT_EQ(info.value().states, 7u);
  EXPECT_EQ(store_->find("x").error().code, ErrorCode::kNotFound);
}

TEST_F(TableStoreTest, ThoseOfTheSameMethodAndSceneFit) {
  add(table('a', 1));
  add(table('b', 2));
  add(table('c', 1));
  TableFile other = table('d', 1);
  other.header.method = "other";
  add(other);
  TableFile lit = table('e', 1);
  lit.header.lights.bytes[0] = 1;
  add(lit);
  EXPECT_EQ(fitting(1), (std::vector<std::string>{std::string(32, 'c'), std::string(32, 'a')}));
  EXPECT_EQ(fitting(1, 1), (std::vector<std::string>{std::string(32, 'c')}));
  EXPECT_TRUE(fitting(3).empty());
  const auto all = store_->list(100);
  ASSERT_EQ(all.value().size(), 5u);
  EXPECT_EQ(all.value()[0].id, std::string(32, 'e'));
}

TEST_F(TableStoreTest, TheOneThatHasSeenTheMostComesFirst) {
  add(table('a'), 100);
  add(table('b'), 300);
  add(table('c'), 200);
  EXPECT_EQ(fitting(0, 2), (std::vector<std::string>{std::string(32, 'b'), std::string(32, 'c')}));
}

TEST_F(TableStoreTest, TheSameTableAgainIsTheNewest) {
  add(table('a'));
  add(table('b'));
  add(table('a'));
  EXPECT_EQ(fitting(0), (std::vector<std::string>{std::string(32, 'a'), std::string(32, 'b')}));
}

TEST_F(TableStoreTest, ADamagedFileGoesToQuarantine) {
  add(table('a'));
  add(table('b'));
  const fs::path file = scratch_ / ("tables/" + std::string(32, 'b') + ".qrt");
  Bytes bytes = read_file(file, 1 << 20).value();
  bytes[bytes.size() / 2] ^= 1;
  ASSERT_TRUE(write_file_atomic(file, bytes).ok());
  const Result<TableFile> loaded = store_->load(std::string(32, 'b'));
  ASSERT_FALSE(loaded.ok());
  EXPECT_FALSE(fs::exists(file));
  EXPECT_TRUE(fs::exists(scratch_ / ("quarantine/" + std::string(32, 'b') + ".qrt")));
  EXPECT_EQ(fitting(0), std::vector<std::string>{std::string(32, 'a')});
}

TEST_F(TableStoreTest, AFileOfAnotherTableGoesToQuarantine) {
  add(table('a'));
  const std::string id(32, 'a');
  ASSERT_TRUE(
      write_file_atomic(scratch_ / ("tables/" + id + ".qrt"), encode_table(table('b'))).ok());
  EXPECT_FALSE(store_->load(id).ok());
  EXPECT_TRUE(fs::exists(scratch_ / ("quarantine/" + id + ".qrt")));
}

TEST_F(TableStoreTest, AMissingFile) {
  add(table('a'));
  fs::remove(scratch_ / ("tables/" + std::string(32, 'a') + ".qrt"));
  EXPECT_EQ(store_->load(std::string(32, 'a')).error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace qray::server
