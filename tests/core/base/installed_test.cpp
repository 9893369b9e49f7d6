#include "core/base/installed.h"

#include <gtest/gtest.h>

#include "tests/support/scratch.h"

namespace qray {
namespace {

TEST(Installed, TheProgramsPrefixIsLookedAtFirst) {
  const test::ScratchFolder scratch;
  const std::filesystem::path bin = scratch.path() / "bin";
  EXPECT_EQ(installed_or("scenes", "source/scenes", bin), "source/scenes");
  const std::filesystem::path installed = scratch.path() / "share/qray/scenes";
  std::filesystem::create_directories(installed);
  EXPECT_EQ(installed_or("scenes", "source/scenes", bin), installed);
  EXPECT_EQ(installed_or("web", "source/web", bin), "source/web");
}

TEST(Installed, ABuildTreeUsesItsSources) {
  EXPECT_EQ(installed_or("scenes", "source/scenes"), "source/scenes");
}

}  // namespace
}  // namespace qray
