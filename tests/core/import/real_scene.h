// Scenes that others made: they load, where they are there.
#pragma once

#include <gtest/gtest.h>

#include "core/import/load_scene.h"
#include "tests/support/places.h"

namespace qray::test {

struct RealScene {
  const char* file;  // in testdata_dir()
  size_t triangles, warnings;
};

inline void expect_loads(const RealScene& scene) {
  const std::filesystem::path path = testdata_dir() / scene.file;
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no test data: " << path << " is not there";
  const auto loaded = load_scene(path);
  ASSERT_TRUE(loaded.ok()) << loaded.error().text();
  EXPECT_EQ(loaded.value().scene.triangle_count() + loaded.value().dropped_triangles,
            scene.triangles);
  EXPECT_EQ(loaded.value().warnings.size(), scene.warnings)
      << (loaded.value().warnings.empty() ? "" : loaded.value().warnings[0]);
}

}  // namespace qray::test
