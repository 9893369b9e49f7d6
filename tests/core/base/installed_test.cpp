#include "core/base/installed.h"

#include <gtest/gtest.h>

#include "tests/support/scratch.h"

namespace qray {
namespace {

TEST(Installed, TheProgramsPrefixIsLookedAtFirst) {
  const test::ScratchFolder scratch;
  const std::filesystem::path bin = scratch.path() / "bin/qray";
  const std::filesystem::path newer = scratch.path() / kNewerPrograms / "qray";
  EXPECT_EQ(beside_program("share/x", "source/x", bin), "source/x");
  const std::filesystem::path installed = scratch.path() / "share/x";
  std::filesystem::create_directories(installed);
  for (const std::filesystem::path& program : {bin, newer}) {
    EXPECT_EQ(beside_program("share/x", "source/x", program), installed);
    EXPECT_EQ(beside_program("share/y", "source/y", program), "source/y");
  }
  EXPECT_EQ(beside_program("share/x", "source/x", newer.parent_path() / "more/qray"), "source/x");
}

TEST(Installed, ABuildTreeUsesItsSources) {
  EXPECT_EQ(installed_or("scenes", "source/scenes"), "source/scenes");
}

}  // namespace
}  // namespace qray
