#include "core/render/features.h"

#include <gtest/gtest.h>

#include "tests/support/render.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

Image features_of(const char* scene, int threads = 2) {
  TaskPool pool(threads);
  return render_features(*test::included_scene(scene), test::small_settings("none", 32, 1), pool,
                         {})
      .value()
      .features;
}

float length_of_normal(const Image& f, int x, int y) {
  return length(Vec3{f.at(x, y, 3), f.at(x, y, 4), f.at(x, y, 5)});
}

// Whether the kind of surface is the same all around: no mean of several.
bool is_inside(const Image& f, int x, int y) {
  if (x == 0 || y == 0 || x == f.width() - 1 || y == f.height() - 1) return false;
  for (int dy : {-1, 0, 1})
    for (int dx : {-1, 0, 1})
      for (int k = 3; k < kFeatureChannels; ++k)
        if (std::abs(f.at(x, y, k) - f.at(x + dx, y + dy, k)) > 0.05f) return false;
  return true;
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
      EXPECT_LT(length_of_normal(f, x, y), 1.0001f) << x << ", " << y;
      if (is_inside(f, x, y)) {
        EXPECT_NEAR(length_of_normal(f, x, y), surface ? 1 : 0, 1e-3) << x << ", " << y;
      }
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

// A black lamp of radiance 16 above, and below its image in a mirror that is tinted.
std::shared_ptr<const PreparedScene> lamp_over_mirror() {
  Scene scene;
  scene.name = "lamp";
  const MaterialId lamp = test::add_material(scene, Rgb{0.0f}, Rgb{16.0f, 16.0f, 0.5f});
  const MaterialId mirror = test::add_material(scene, Rgb{0.0f});
  scene.materials.back().kind = MaterialKind::kConductor;
  scene.materials.back().eta = Rgb{0.2f};
  scene.materials.back().k = Rgb{3.9f};
  scene.materials.back().specular.value = Rgb{0.5f, 0.25f, 0.5f};
  test::add_quad(scene, lamp, {-9, 0, -1}, {18, 0, 0}, {0, 9, 0});
  test::add_quad(scene, mirror, {-9, 0, -1}, {0, 0, 9}, {18, 0, 0});
  scene.camera.position = {0, 1, 1};
  scene.camera.target = {0, 0.5f, -1};
  scene.camera.vertical_fov_deg = 80;
  return test::prepare(std::move(scene));
}

TEST(Features, WhatShinesInAMirrorIsWhiteAsFarAsItShines) {
  TaskPool pool(2);
  const FeaturePictures p =
      render_features(*lamp_over_mirror(), test::small_settings("none", 32, 1), pool, {}).value();
  const Image& f = p.features;
  EXPECT_EQ(f.at(16, 4, 7), 1) << "a lamp";
  EXPECT_EQ(f.at(16, 4, 0), 0) << "what it shows is taken off, what it reflects is none";
  EXPECT_EQ(p.emitted.at(16, 4, 0), 16);
  EXPECT_EQ(f.at(16, 29, 7), 1.75f) << "a lamp in a mirror";
  EXPECT_GT(f.at(16, 29, 0), 0.3f);
  EXPECT_NEAR(f.at(16, 29, 2) / f.at(16, 29, 0), 0.5f, 0.2f);
  EXPECT_EQ(p.emitted.at(16, 29, 0), 0);
}

TEST(Features, APixelOnAnEdgeHasAShareOfBothSides) {
  TaskPool pool(2);
  const FeaturePictures p =
      render_features(*lamp_over_mirror(), test::small_settings("none", 32, 1), pool, {}).value();
  int shares = 0;
  for (int y = 0; y < 32; ++y) {
    const float part = p.emitted.at(16, y, 0) / 16;
    EXPECT_EQ(4 * part, std::round(4 * part)) << "of four rays";
    shares += part > 0 && part < 1;
  }
  EXPECT_LE(shares, 1);
}

TEST(Features, AreTheSameForAnyNumberOfThreads) {
  const Image one = features_of("thesis-room", 1), three = features_of("thesis-room", 3);
  EXPECT_TRUE(std::equal(one.data().begin(), one.data().end(), three.data().begin()));
}

}  // namespace
}  // namespace qray
