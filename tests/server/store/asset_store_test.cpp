#include "server/store/asset_store.h"

#include <gtest/gtest.h>

#include <fstream>
#include <thread>

#include "tests/support/scratch.h"

namespace qray::server {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kBlock = DiskQuota::on_disk(0);

std::span<const uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

std::string name_of(const std::string& text) { return sha256(bytes_of(text)).hex(); }

class AssetStoreTest : public ::testing::Test {
 protected:
  void SetUp() override { open(); }
  void open() {
    store_.reset();
    quota_ = std::make_unique<DiskQuota>(100 * kBlock);
    auto opened = AssetStore::open(scratch_.path(), *quota_);
    ASSERT_TRUE(opened.ok()) << opened.error().text();
    store_ = std::move(opened).value();
  }
  Status put(const std::string& text, const std::string& name) {
    Result<AssetStore::Upload> upload = store_->begin(name, text.size());
    if (!upload.ok()) return upload.error();
    if (Status s = upload.value().add(bytes_of(text)); !s.ok()) return s;
    return upload.value().commit();
  }
  size_t files() const {
    return static_cast<size_t>(std::distance(fs::directory_iterator(folder_), {}));
  }
  qray::test::ScratchFolder scratch_;
  const fs::path folder_ = scratch_.path() / "assets";
  std::unique_ptr<DiskQuota> quota_;
  std::unique_ptr<AssetStore> store_;
};

TEST_F(AssetStoreTest, KeepsWhatHasItsName) {
  const std::string text = "some bytes";
  EXPECT_FALSE(store_->has(name_of(text)));
  ASSERT_TRUE(put(text, name_of(text)).ok());
  EXPECT_TRUE(store_->has(name_of(text)));
  std::string read;
  std::getline(std::ifstream(folder_ / name_of(text)), read);
  EXPECT_EQ(read, text);
  ASSERT_TRUE(put(text, name_of(text)).ok());
  EXPECT_EQ(files(), 1u);
  EXPECT_EQ(quota_->used(), kBlock) << "the same bytes count once";
  open();
  EXPECT_TRUE(store_->has(name_of(text)));
  EXPECT_EQ(quota_->used(), kBlock);
}

TEST_F(AssetStoreTest, OtherBytesAreRefusedWithBothNames) {
  const Status s = put("other", name_of("some"));
  ASSERT_FALSE(s.ok());
  EXPECT_EQ(s.error().code, ErrorCode::kInvalid);
  for (const char* text : {"other", "some"})
    EXPECT_NE(s.error().message.find(name_of(text)), std::string::npos);
  EXPECT_EQ(files(), 0u);
  EXPECT_EQ(quota_->used(), 0u);
}

TEST_F(AssetStoreTest, ABrokenUploadLeavesNothing) {
  {
    Result<AssetStore::Upload> upload = store_->begin(name_of("abc"), 3);
    ASSERT_TRUE(upload.ok());
    ASSERT_TRUE(upload.value().add(bytes_of("ab")).ok());
    EXPECT_EQ(files(), 1u);
    EXPECT_FALSE(store_->has(name_of("abc")));
    EXPECT_EQ(upload.value().add(bytes_of("cd")).error().code, ErrorCode::kTooLarge);
  }
  EXPECT_EQ(files(), 0u);
  EXPECT_EQ(quota_->used(), 0u);
  std::ofstream(folder_ / (name_of("abc") + ".7.part")) << "ab";  // of a server that was killed
  open();
  EXPECT_EQ(files(), 0u);
  EXPECT_EQ(quota_->used(), 0u);
}

TEST_F(AssetStoreTest, TheQuotaCountsWhatIsOnItsWay) {
  Result<AssetStore::Upload> first = store_->begin(name_of("a"), 60 * kBlock - 1);
  ASSERT_TRUE(first.ok());
  EXPECT_EQ(store_->begin(name_of("b"), 40 * kBlock).error().code, ErrorCode::kTooLarge);
  EXPECT_EQ(store_->begin(name_of("b"), UINT64_MAX).error().code, ErrorCode::kTooLarge);
  EXPECT_TRUE(store_->begin(name_of("b"), 40 * kBlock - 1).ok());
}

TEST_F(AssetStoreTest, TheUnusedGoWhenRoomIsWantedOrTimeHasPassed) {
  const std::string old(50 * kBlock - 1, 'o'), used(50 * kBlock - 1, 'u');
  ASSERT_TRUE(put(old, name_of(old)).ok());
  ASSERT_TRUE(put(used, name_of(used)).ok());
  ASSERT_TRUE(store_->link(name_of(used), scratch_.path() / "link").ok());
  const std::string fresh(40 * kBlock - 1, 'f');
  EXPECT_FALSE(put(fresh, name_of(fresh)).ok()) << "nothing is old yet";
  const auto past = fs::file_time_type::clock::now() - 2 * AssetStore::kKeepUnused;
  for (const std::string& text : {old, used}) fs::last_write_time(folder_ / name_of(text), past);
  EXPECT_TRUE(put(fresh, name_of(fresh)).ok());
  EXPECT_FALSE(store_->has(name_of(old)));
  EXPECT_TRUE(store_->has(name_of(used)));
  EXPECT_EQ(quota_->used(), 90 * kBlock);
  fs::last_write_time(folder_ / name_of(fresh), past);
  EXPECT_TRUE(store_->has(name_of(fresh))) << "asked for: kept an hour more";
  store_->remove_unused();
  EXPECT_TRUE(store_->has(name_of(fresh)));
}

TEST_F(AssetStoreTest, ManyAtOnceOfOneNameWriteOneFile) {
  const std::string text = "seven s";
  std::atomic<int> stored{0};
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 8; ++i)
      threads.emplace_back([&] { stored += put(text, name_of(text)).ok(); });
  }
  EXPECT_EQ(stored, 8);
  EXPECT_EQ(files(), 1u);
  EXPECT_EQ(quota_->used(), kBlock);
}

TEST_F(AssetStoreTest, ADiskThatFailsIsAnError) {
  fs::remove_all(folder_);
  const Status s = put("abc", name_of("abc"));
  ASSERT_FALSE(s.ok());
  EXPECT_EQ(s.error().code, ErrorCode::kIo);
  EXPECT_EQ(quota_->used(), 0u);
}

}  // namespace
}  // namespace qray::server
