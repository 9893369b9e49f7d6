#include "core/render/features.h"

#include <gtest/gtest.h>

#include "tests/support/render.h"

namespace qray {
namespace {

Image features_of(const char* scene, int threads = 2) {
  TaskPool pool(threads);
  return render_features(*test::included_scene(scene), test::small_settings("none", 32, 1), pool,
                         {})
      .value();
}

float length_of_normal(const Image& f, int x, int y) {
  return length(Vec3{f.at(x, y, 3), f.at(x, y, 4), f.at(x, y, 5)});
}

TEST(Features, AreOfTheFirstSurfaceInTheirUnits) {
  const Image f = features_of("cornell-box");
  ASSERT_EQ(f.channels(), kFeatureChannels);
  int surfaces = 0;
  for (int y = 0; y < f.height(); ++y)
    for (int x = 0; x < f.width(); ++x) {
      for (int c = 0; c < 3; ++c) {
        EXPECT_GE(f.at(x, y, c), 0);
        EXPECT_LE(f.at(x, y, c), 1);
      }
      const bool surface = f.at(x, y, 7) < 2;
      surfaces += surface;
      EXPECT_NEAR(length_of_normal(f, x, y), surface ? 1 : 0, 1e-4) << x << ", " << y;
      EXPECT_GT(f.at(x, y, 6), 0);
      EXPECT_LE(f.at(x, y, 6), 2);
    }
  EXPECT_GT(surfaces, 32 * 32 / 2);
}

TEST(Features, FollowMirrorsToWhatIsSeenInThem) {
  // Behind glass the kind says so, and the path is longer than to the glass.
  const Image f = features_of("glass-caustic");
  int behind = 0;
  for (int y = 0; y < f.height(); ++y)
    for (int x = 0; x < f.width(); ++x) behind += f.at(x, y, 7) >= 0.75f && f.at(x, y, 7) < 1;
  EXPECT_GT(behind, 3);
}

TEST(Features, AreTheSameForAnyNumberOfThreads) {
  const Image one = features_of("thesis-room", 1), three = features_of("thesis-room", 3);
  EXPECT_TRUE(std::equal(one.data().begin(), one.data().end(), three.data().begin()));
}

}  // namespace
}  // namespace qray
