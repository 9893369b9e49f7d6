#include "core/laboratory/generated_scene.h"

#include <gtest/gtest.h>

#include <set>

#include "core/laboratory/screenshots.h"
#include "core/scene/scene_hash.h"
#include "core/scene/validate.h"

namespace qray {
namespace {

TEST(GeneratedScene, EverySeedMakesAnotherRoomThatCanBeLookedAtFromInside) {
  std::set<std::string> seen;
  for (uint64_t seed = 1; seed <= 12; ++seed) {
    Scene scene = generated_scene(seed);
    const Result<ValidateReport> report = validate(scene);
    ASSERT_TRUE(report.ok()) << seed << ": " << report.error().text();
    EXPECT_EQ(report.value().dropped_triangles, 0u) << seed;
    const SceneHash hash = hash_scene(scene).value();
    EXPECT_TRUE(seen.insert(hash.whole().hex()).second) << seed;
    Scene again = generated_scene(seed);
    ASSERT_TRUE(validate(again).ok());
    EXPECT_TRUE(hash_scene(again).value() == hash) << seed;
    const Result<std::shared_ptr<PreparedScene>> prepared =
        prepare_scene(std::move(scene), hash, 1);
    ASSERT_TRUE(prepared.ok()) << seed;
    EXPECT_EQ(screenshot_cameras(*prepared.value(), 4, 512, 1).size(), 4u) << seed;
  }
}

}  // namespace
}  // namespace qray
