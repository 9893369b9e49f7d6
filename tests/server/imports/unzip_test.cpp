// Archives that try what archives have tried.
#include "server/imports/unzip.h"

#include <gtest/gtest.h>

#include "tests/server/make_zip.h"
#include "tests/support/scratch.h"

namespace qray::server {
namespace {

namespace fs = std::filesystem;
using test::make_zip;
using test::replaced;
using test::ZipEntry;

std::string little_endian(uint32_t v) {
  return {static_cast<char>(v), static_cast<char>(v >> 8), static_cast<char>(v >> 16),
          static_cast<char>(v >> 24)};
}

class UnzipTest : public ::testing::Test {
 protected:
  Result<Unzipped> unpack(const std::string& bytes, uint64_t max_bytes = 1 << 20) {
    fs::remove_all(out_);
    fs::create_directories(out_);
    std::ofstream(scratch_ / "a.zip", std::ios::binary) << bytes;
    return unzip(scratch_ / "a.zip", out_, max_bytes);
  }
  void expect_refused(const std::string& bytes, const std::string& where, const std::string& what,
                      uint64_t max_bytes = 1 << 20) {
    const Result<Unzipped> unzipped = unpack(bytes, max_bytes);
    ASSERT_FALSE(unzipped.ok()) << where;
    EXPECT_EQ(unzipped.error().where, where) << unzipped.error().text();
    EXPECT_NE(unzipped.error().message.find(what), std::string::npos) << unzipped.error().text();
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(scratch_.path()))
      EXPECT_NE(entry.path().filename(), "evil");
  }
  qray::test::ScratchFolder scratch_;
  const fs::path out_ = scratch_ / "in/out";
};

TEST_F(UnzipTest, UnpacksFilesInFolders) {
  const std::string big(300'000, 'b');
  const Result<Unzipped> unzipped = unpack(make_zip(scratch_.path(), {{"room/scene.json", "{}"},
                                                                      {"room/", "", S_IFDIR | 0755},
                                                                      {"room/textures/a.png", big},
                                                                      {"empty", ""}}));
  ASSERT_TRUE(unzipped.ok()) << unzipped.error().text();
  EXPECT_EQ(unzipped.value().names,
            (std::vector<std::string>{"room/scene.json", "room/textures/a.png", "empty"}));
  EXPECT_EQ(unzipped.value().bytes, 300'002u);
  EXPECT_EQ(test::file_text(out_ / "room/textures/a.png"), big);
  EXPECT_EQ(fs::file_size(out_ / "empty"), 0u);
}

TEST_F(UnzipTest, NamesThatLeadElsewhereAreRefused) {
  for (const std::string name : {"../evil", "/evil", "a/../../evil", "a\\..\\evil", "./evil"}) {
    expect_refused(make_zip(scratch_.path(), {{"good", "x"}, {name, "x"}}), name, "expected");
    EXPECT_TRUE(fs::is_empty(out_)) << "refused before anything is written";
  }
  expect_refused(make_zip(scratch_.path(), {{"../evil/", "", S_IFDIR | 0755}}), "../evil", "..");
  expect_refused(make_zip(scratch_.path(), {{std::string(300, 'n'), "x"}}), std::string(300, 'n'),
                 "255 bytes");
}

TEST_F(UnzipTest, LinksAndDevicesAreRefused) {
  for (const mode_t kind : {S_IFLNK, S_IFIFO, S_IFCHR, S_IFDIR})
    expect_refused(make_zip(scratch_.path(), {{"evil", "/etc/passwd", kind | 0777}}), "evil",
                   "link");
}

TEST_F(UnzipTest, NamesGivenTwiceAreRefused) {
  const std::string two = make_zip(scratch_.path(), {{"name-1", "x"}, {"name-2", "y"}});
  expect_refused(replaced(two, "name-2", "name-1"), "", "exists");  // libzip sees this one
  expect_refused(replaced(two, "name-2", "NAME-1"), "NAME-1", "same name");
  expect_refused(make_zip(scratch_.path(), {{"a", "x"}, {"a/b", "y"}}), "a/b", "is a file");
}

TEST_F(UnzipTest, ABombIsRefusedByWhatItSaysAndByWhatItHolds) {
  const std::string zeros(900'000, '\0');
  const std::string bomb = make_zip(scratch_.path(), {{"a", zeros}, {"b", zeros}});
  EXPECT_LT(bomb.size(), 5000u);
  expect_refused(bomb, "b", "more than 1048576 bytes");
  EXPECT_TRUE(fs::is_empty(out_));
  // The same, saying that each is small.
  const std::string liar = replaced(bomb, little_endian(900'000), little_endian(9'000));
  expect_refused(liar, "a", "");
  uintmax_t written = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(out_))
    written += entry.file_size();
  EXPECT_LE(written, 9'000u);
}

TEST_F(UnzipTest, AFileShorterThanItsHeaderSaysIsRefused) {
  const std::string zeros(9'000, '\0');
  const std::string good = make_zip(scratch_.path(), {{"a", zeros}});
  expect_refused(replaced(good, little_endian(9'000), little_endian(90'000)), "a", "");
}

TEST_F(UnzipTest, DamageIsRefused) {
  std::string bytes = make_zip(scratch_.path(), {{"a", std::string(1000, 'a') + "the end"}});
  expect_refused("", "", "not a zip");
  expect_refused("PK\3\4 nonsense", "", "not a zip");
  expect_refused(bytes.substr(0, bytes.size() / 2), "", "not a zip");
  const size_t data = bytes.find('a', 30) + 4;
  bytes[data] = static_cast<char>(bytes[data] ^ 0x55);
  expect_refused(bytes, "a", "");
}

TEST_F(UnzipTest, ThousandsOfFilesAreRefused) {
  std::vector<ZipEntry> entries;
  for (int i = 0; i < 4097; ++i) entries.push_back({"f" + std::to_string(i), ""});
  expect_refused(make_zip(scratch_.path(), entries), "f4096", "4096 files");
  entries.clear();
  for (int i = 0; i < 8193; ++i) entries.push_back({"d" + std::to_string(i) + "/", "", S_IFDIR});
  expect_refused(make_zip(scratch_.path(), entries), "", "8192 entries");
}

}  // namespace
}  // namespace qray::server
