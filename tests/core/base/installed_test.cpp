#include "core/base/installed.h"

#include <gtest/gtest.h>

#include "tests/support/scratch.h"

namespace qray {
namespace {

TEST(Installed, TheProgramsPrefixIsLookedAtFirst) {
  const test::ScratchFolder scratch;
  const std::filesystem::path bin = scratch.path() / "bin";
  EXPECT_EQ(beside_program("share/x", "source/x", bin), "source/x");
  const std::filesystem::path installed = scratch.path() / "share/x";
  std::filesystem::create_directories(installed);
  EXPECT_EQ(beside_program("share/x", "source/x", bin), installed);
  EXPECT_EQ(beside_program("share/y", "source/y", bin), "source/y");
}

TEST(Installed, ABuildTreeUsesItsSources) {
  EXPECT_EQ(installed_or("scenes", "source/scenes"), "source/scenes");
}

}  // namespace
}  // namespace qray
