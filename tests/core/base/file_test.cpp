#include "core/base/file.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "tests/support/scratch.h"

namespace qray {
namespace {

size_t files_in(const std::filesystem::path& folder) {
  const std::filesystem::directory_iterator all(folder);
  return static_cast<size_t>(std::distance(begin(all), end(all)));
}

TEST(File, WritesAndReplaces) {
  const test::ScratchFolder folder;
  ASSERT_TRUE(write_file_atomic(folder / "a", Bytes{1, 2, 3}).ok());
  EXPECT_EQ(read_file(folder / "a", 3).value(), (Bytes{1, 2, 3}));
  ASSERT_TRUE(write_file_atomic(folder / "a", Bytes{}).ok());
  EXPECT_EQ(read_file(folder / "a", 0).value(), Bytes{});
  EXPECT_EQ(files_in(folder.path()), 1u);
}

TEST(File, FailuresLeaveTheOldBytesAndNothingElse) {
  const test::ScratchFolder folder;
  EXPECT_EQ(write_file_atomic(folder / "none" / "a", Bytes{1}).error().code, ErrorCode::kIo);
  // A folder in the file's place cannot be renamed onto.
  std::filesystem::create_directories(folder / "a" / "inside");
  const Status status = write_file_atomic(folder / "a", Bytes{1});
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().where, (folder / "a").string());
  EXPECT_EQ(files_in(folder.path()), 1u);
  EXPECT_TRUE(std::filesystem::is_directory(folder / "a" / "inside"));
}

TEST(File, ReadErrorsSayWhich) {
  const test::ScratchFolder folder;
  EXPECT_EQ(read_file(folder / "none", 10).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(read_file(folder / "none", 10).error().where, (folder / "none").string());
  ASSERT_TRUE(write_file_atomic(folder / "a", Bytes(11)).ok());
  EXPECT_EQ(read_file(folder / "a", 10).error().code, ErrorCode::kTooLarge);
  EXPECT_FALSE(read_file(folder.path(), 1 << 20).ok());
}

TEST(File, ReadersSeeOldOrNewNeverAMixture) {
  const test::ScratchFolder folder;
  const std::filesystem::path path = folder / "a";
  ASSERT_TRUE(write_file_atomic(path, Bytes(5000, 0)).ok());
  std::jthread first([&] {
    for (int i = 0; i < 20; ++i) EXPECT_TRUE(write_file_atomic(path, Bytes(9000, 1)).ok());
  });
  std::jthread second([&] {
    for (int i = 0; i < 20; ++i) EXPECT_TRUE(write_file_atomic(path, Bytes(5000, 2)).ok());
  });
  for (int i = 0; i < 200; ++i) {
    const Result<Bytes> bytes = read_file(path, 9000);
    ASSERT_TRUE(bytes.ok()) << bytes.error().text();
    const uint8_t who = bytes.value().front();
    ASSERT_EQ(bytes.value(), Bytes(who == 1 ? 9000 : 5000, who));
  }
  first.join();
  second.join();
  EXPECT_EQ(files_in(folder.path()), 1u);
}

TEST(MappedFile, StaysAsItWasWhenTheFileIsReplaced) {
  const test::ScratchFolder folder;
  ASSERT_TRUE(write_file_atomic(folder / "a", Bytes{1, 2, 3}).ok());
  Result<MappedFile> opened = MappedFile::open(folder / "a", 3);
  ASSERT_TRUE(opened.ok());
  const MappedFile file = std::move(opened).value();
  ASSERT_TRUE(write_file_atomic(folder / "a", Bytes{4}).ok());
  EXPECT_EQ(Bytes(file.bytes().begin(), file.bytes().end()), (Bytes{1, 2, 3}));
  ASSERT_TRUE(write_file_atomic(folder / "empty", Bytes{}).ok());
  EXPECT_TRUE(MappedFile::open(folder / "empty", 3).value().bytes().empty());
  EXPECT_EQ(MappedFile::open(folder / "none", 3).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(MappedFile::open(folder.path(), 3).error().code, ErrorCode::kIo);
  ASSERT_TRUE(write_file_atomic(folder / "a", Bytes(4)).ok());
  EXPECT_EQ(MappedFile::open(folder / "a", 3).error().code, ErrorCode::kTooLarge);
}

}  // namespace
}  // namespace qray
