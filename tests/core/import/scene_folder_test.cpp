#include "core/import/scene_folder.h"

#include <gtest/gtest.h>

#include "tests/core/import/scene_text.h"

namespace qray {
namespace {

namespace fs = std::filesystem;

TEST(SceneFolder, OnlyWhatLiesBelowIsFound) {
  const test::SceneFolder scratch;
  const fs::path outside = scratch.write("out.ply", "x");
  scratch.write("in/a.ply", "x");
  scratch.write("in/deep/b.ply", "x");
  const fs::path in = fs::canonical(scratch.path() / "in");
  fs::create_symlink(outside, in / "link.ply");
  fs::create_symlink(scratch.path(), in / "up");
  fs::create_symlink("deep", in / "shallow");
  for (const char* name : {"a.ply", "./a.ply", "deep/../a.ply", "deep/b.ply", "shallow/b.ply"})
    EXPECT_TRUE(find_within(in, in, name).ok()) << name;
  EXPECT_TRUE(find_within(in, in / "deep", "../a.ply").ok());
  const std::string absolute = (in / "a.ply").string();
  for (const std::string& name :
       {std::string("../out.ply"), outside.string(), absolute, std::string("../in/a.ply"),
        std::string("deep/../../in/a.ply"), std::string("link.ply"), std::string("up/out.ply"),
        std::string("up/in/../out.ply"), std::string("deep"), std::string(), std::string("."),
        std::string("gone.ply"), std::string("gone/../../out.ply"), std::string("/")}) {
    const Result<fs::path> found = find_within(in, in, name);
    ASSERT_FALSE(found.ok()) << name;
    EXPECT_EQ(found.error().code, ErrorCode::kNotFound);
    EXPECT_EQ(found.error().message, "no such file in the scene's folder: \"" + name + "\"");
  }
  EXPECT_FALSE(find_within(in, in / "deep", "../../out.ply").ok());
}

}  // namespace
}  // namespace qray
