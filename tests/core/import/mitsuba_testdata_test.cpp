// Real scenes load, where they are there.
#include <gtest/gtest.h>

#include "core/import/load_scene.h"
#include "tests/support/places.h"

namespace qray {
namespace {

struct RealMitsubaScene {
  const char* file;
  size_t triangles, warnings;
};

class MitsubaTestdata : public testing::TestWithParam<RealMitsubaScene> {};

LoadedScene load(const char* file) {
  auto loaded = load_scene(test::testdata_dir() / file);
  EXPECT_TRUE(loaded.ok()) << file << ": " << loaded.error().text();
  return loaded.ok() ? std::move(loaded).value() : LoadedScene{};
}

bool is_there(const char* file) { return std::filesystem::exists(test::testdata_dir() / file); }

TEST_P(MitsubaTestdata, Loads) {
  const RealMitsubaScene& scene = GetParam();
  if (!is_there(scene.file)) GTEST_SKIP() << "no test data: " << scene.file << " is not there";
  const LoadedScene loaded = load(scene.file);
  EXPECT_EQ(loaded.scene.triangle_count() + loaded.dropped_triangles, scene.triangles);
  EXPECT_EQ(loaded.warnings.size(), scene.warnings)
      << (loaded.warnings.empty() ? "" : loaded.warnings[0]);
}

INSTANTIATE_TEST_SUITE_P(All, MitsubaTestdata,
                         testing::Values(RealMitsubaScene{"cornell-box/scene_v0.5.xml", 36, 0},
                                         RealMitsubaScene{"cornell-box/scene_v3.xml", 36, 0},
                                         RealMitsubaScene{"veach-ajar/scene_v0.5.xml", 382690, 0},
                                         RealMitsubaScene{"veach-ajar/scene_v3.xml", 382690, 0},
                                         RealMitsubaScene{"veach-mis/scene_v0.5.xml", 48436, 0},
                                         RealMitsubaScene{"veach-mis/scene_v3.xml", 48436, 0},
                                         RealMitsubaScene{"living-room/scene_v0.5.xml", 143163, 1},
                                         RealMitsubaScene{"staircase2/scene_v0.5.xml", 31247, 0},
                                         RealMitsubaScene{"cbox-bulb/scene_v0.6.xml", 62518, 0},
                                         RealMitsubaScene{"cbox-bulb/include_v0.6.xml", 62518, 0},
                                         RealMitsubaScene{"many-lights-a/scene_v0.6.xml", 168556,
                                                          0}));

TEST(MitsubaVersions, OldAndNewFilesOfASceneAreTheSame) {
  for (const std::string folder : {"cornell-box", "veach-ajar", "veach-mis"}) {
    const std::string old = folder + "/scene_v0.5.xml", young = folder + "/scene_v3.xml";
    if (!is_there(old.c_str())) GTEST_SKIP() << "no test data: " << old << " is not there";
    const LoadedScene a = load(old.c_str()), b = load(young.c_str());
    // veach-mis has its spheres by a matrix in one and by their centre in the other.
    if (folder != "veach-mis") {
      EXPECT_EQ(a.hash.geometry, b.hash.geometry) << folder;
    }
    EXPECT_EQ(a.scene.triangle_count(), b.scene.triangle_count());
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(a.scene.bounds().lo[axis], b.scene.bounds().lo[axis], 1e-4f) << folder;
      EXPECT_NEAR(a.scene.bounds().hi[axis], b.scene.bounds().hi[axis], 1e-4f) << folder;
    }
    EXPECT_EQ(a.scene.camera, b.scene.camera) << folder;
    EXPECT_EQ(a.scene.width, b.scene.width);
  }
}

}  // namespace
}  // namespace qray
