#include "core/base/file_names.h"

#include <gtest/gtest.h>

namespace qray {
namespace {

TEST(FileNames, TakesPlainRelativeNames) {
  FileNames names;
  for (const char* name : {"scene.json", "textures/a.png", "textures/b.png", "a b/c..d/.e",
                           "1/2/3/4/5/6/7/8", "\xc3\xa9\xe2\x82\xac\xf0\x9f\x98\x80.png"}) {
    EXPECT_EQ(names.add(name), std::nullopt) << name;
  }
  EXPECT_EQ(names.add(std::string(255, 'x')), std::nullopt);
}

TEST(FileNames, RefusesTricksSayingWhich) {
  using std::string;
  const std::pair<string, const char*> cases[] = {
      {"", "empty"},
      {"/etc/passwd", "relative"},
      {"../x", ".."},
      {"a/../b", ".."},
      {"a/..", ".."},
      {"./a", ". and"},
      {"a//b", "empty parts"},
      {"a/", "empty parts"},
      {"a\\..\\b", "backslash"},
      {"C:\\x", "backslash"},
      {string("a\0b", 3), "control"},
      {"a\nb", "control"},
      {"a\x7f", "control"},
      {"1/2/3/4/5/6/7/8/9", "8 parts"},
      {string(256, 'x'), "255 bytes"},
      {"\xff", "UTF-8"},
      {"\xc0\xaf", "UTF-8"},          // an overlong slash
      {"\xe0\x80\xaf", "UTF-8"},      // another
      {"\xed\xa0\x80", "UTF-8"},      // a surrogate
      {"\xf4\x90\x80\x80", "UTF-8"},  // above U+10FFFF
      {"a\xe2\x82", "UTF-8"},         // cut short
      {"\x80", "UTF-8"},
  };
  for (const auto& [name, part] : cases) {
    const std::optional<string> fault = FileNames().add(name);
    ASSERT_TRUE(fault) << name;
    EXPECT_NE(fault->find(part), string::npos) << name << ": " << *fault;
  }
}

TEST(FileNames, NoTwoAreTheSameFile) {
  const std::pair<const char*, const char*> clashes[] = {
      {"a.png", "a.png"}, {"a.png", "A.PNG"}, {"x/a", "X/A"},  {"a", "a/b"},
      {"a/b", "a"},       {"A", "a/b/c"},     {"a/b/c", "A/B"}};
  for (const auto& [first, second] : clashes) {
    FileNames names;
    ASSERT_EQ(names.add(first), std::nullopt);
    EXPECT_TRUE(names.add(second)) << first << " and " << second;
  }
  FileNames names;
  for (const char* name : {"a", "b", "ab", "x/a", "x/b"}) EXPECT_EQ(names.add(name), std::nullopt);
}

TEST(FileNames, AreCounted) {
  FileNames names;
  for (size_t i = 0; i < FileNames::kMost; ++i)
    ASSERT_EQ(names.add("f" + std::to_string(i)), std::nullopt);
  EXPECT_TRUE(names.add("one more"));
}

}  // namespace
}  // namespace qray
