#include "tests/core/import/real_scene.h"

namespace qray {
namespace {

using test::RealScene;

class MitsubaTestdata : public testing::TestWithParam<RealScene> {};

TEST_P(MitsubaTestdata, Loads) { test::expect_loads(GetParam()); }

INSTANTIATE_TEST_SUITE_P(All, MitsubaTestdata,
                         testing::Values(RealScene{"cornell-box/scene_v0.5.xml", 36, 0},
                                         RealScene{"cornell-box/scene_v3.xml", 36, 0},
                                         RealScene{"veach-ajar/scene_v0.5.xml", 382690, 0},
                                         RealScene{"veach-ajar/scene_v3.xml", 382690, 0},
                                         RealScene{"veach-mis/scene_v0.5.xml", 52, 1},
                                         RealScene{"veach-mis/scene_v3.xml", 52, 0},
                                         RealScene{"living-room/scene_v0.5.xml", 143163, 1},
                                         RealScene{"staircase2/scene_v0.5.xml", 31247, 0},
                                         RealScene{"cbox-bulb/scene_v0.6.xml", 46390, 0},
                                         RealScene{"cbox-bulb/include_v0.6.xml", 46390, 0},
                                         RealScene{"many-lights-a/scene_v0.6.xml", 556, 0}));

LoadedScene load_testdata(const std::string& file) {
  auto loaded = load_scene(test::testdata_dir() / file);
  EXPECT_TRUE(loaded.ok()) << file << ": " << loaded.error().text();
  return loaded.ok() ? std::move(loaded).value() : LoadedScene{};
}

TEST(MitsubaVersions, OldAndNewFilesOfASceneAreTheSame) {
  for (const std::string folder : {"cornell-box", "veach-ajar", "veach-mis"}) {
    const std::string old = folder + "/scene_v0.5.xml", young = folder + "/scene_v3.xml";
    if (!std::filesystem::exists(test::testdata_dir() / old))
      GTEST_SKIP() << "no test data: " << old << " is not there";
    const LoadedScene a = load_testdata(old), b = load_testdata(young);
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
