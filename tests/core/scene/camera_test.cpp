#include "core/scene/camera.h"

#include <gtest/gtest.h>

#include "tests/support/near.h"

namespace qray {
namespace {

Camera some_camera(Projection projection) {
  Camera camera;
  camera.position = {1, 2, 3};
  camera.target = {-2, 1.5f, -1};
  camera.projection = projection;
  return camera;
}

class EveryProjection : public ::testing::TestWithParam<Projection> {};

TEST_P(EveryProjection, ProjectsBackToItsPixels) {
  Camera camera = some_camera(GetParam());
  const bool all_around = GetParam() == Projection::kEquirectangular;
  for (const bool mirrored : {false, true}) {
    camera.mirrored = mirrored;
    const CameraRays rays(camera, 64, 48);
    for (const Vec2 pixel : {Vec2{0.5f, 0.5f}, {32, 24}, {63.5f, 3.25f}, {-7, 60}}) {
      if (all_around && pixel.x < 0) continue;  // shown at the other edge
      const Ray ray = rays.ray(pixel, {0.5f, 0.5f});
      for (const float t : {0.1f, 7.0f}) {
        const std::optional<Vec2> back = rays.project(ray.o + ray.d * t);
        ASSERT_TRUE(back.has_value());
        EXPECT_NEAR(back->x, pixel.x, 1e-3f);
        EXPECT_NEAR(back->y, pixel.y, 1e-3f);
        EXPECT_NEAR(rays.distance(ray.o + ray.d * t) / rays.distance(ray.o + ray.d), t, 1e-4f * t);
      }
      EXPECT_EQ(rays.project(ray.o - ray.d).has_value(), all_around);
    }
  }
}

// Neighbouring pixels' rays are as far apart as the cone is wide, in the picture's middle.
TEST_P(EveryProjection, ConesAreAsWideAsPixels) {
  Camera camera = some_camera(GetParam());
  camera.height = 3;
  const CameraRays rays(camera, 1024, 512);
  const Ray a = rays.ray({512, 256}, {}), b = rays.ray({512, 257}, {}),
            c = rays.ray({513, 256}, {});
  for (const float t : {0.5f, 40.0f}) {
    const float width = rays.cone().at(t);
    EXPECT_NEAR(length(a.o + a.d * t - b.o - b.d * t) / width, 1, 2e-3f) << t;
    EXPECT_NEAR(length(a.o + a.d * t - c.o - c.d * t) / width, 1, 2e-3f) << t;
  }
}

INSTANTIATE_TEST_SUITE_P(Projections, EveryProjection,
                         ::testing::Values(Projection::kPerspective, Projection::kOrthographic,
                                           Projection::kEquirectangular),
                         [](const auto& info) { return std::string(name_of(info.param)); });

TEST(CameraRays, OrthographicRaysAreParallelAndSpanTheHeight) {
  Camera camera;
  camera.position = {0, 0, 5};
  camera.target = {0, 0, 1};
  camera.projection = Projection::kOrthographic;
  camera.height = 2;
  const CameraRays rays(camera, 100, 50);
  const Ray corner = rays.ray({0, 0}, {}), middle = rays.ray({50, 25}, {});
  test::expect_near(corner.o, {-2, 1, 5}, 1e-6f);
  test::expect_near(middle.o, {0, 0, 5}, 1e-6f);
  for (const Ray& ray : {corner, middle}) EXPECT_EQ(ray.d, (Vec3{0, 0, -1}));
  // Without a height, what the field of view spans at the target, 4 m away.
  camera.height = 0;
  camera.vertical_fov_deg = 2 * std::atan(0.5f) * 180 / kPi;
  test::expect_near(CameraRays(camera, 100, 50).ray({0, 0}, {}).o, {-4, 2, 5}, 1e-5f);
}

// A lens blurs all but its plane, whatever the projection.
TEST(CameraRays, OrthographicLensMeetsInThePlaneInFocus) {
  Camera camera = some_camera(Projection::kOrthographic);
  camera.aperture_radius = 0.2f;
  camera.focus_distance = 3;
  const CameraRays rays(camera, 64, 48);
  const Vec3 forward = normalize(camera.target - camera.position);
  const Ray middle = rays.ray({10, 20}, {0.5f, 0.5f});
  for (const Vec2 u : {Vec2{0.1f, 0.9f}, {0.99f, 0.3f}}) {
    const Ray ray = rays.ray({10, 20}, u);
    EXPECT_GT(length(ray.o - middle.o), 0.05f);
    const float t = 3 / dot(ray.d, forward);
    test::expect_near(ray.o + ray.d * t, middle.o + forward * 3, 1e-5f);
  }
}

// The middle row is the horizon of up, even where the target is above it or below; the middle
// column has the target.
TEST(CameraRays, EquirectangularPicturesStandUpright) {
  Camera camera;
  camera.position = {1, 1, 1};
  camera.target = {1, 4, -2};
  camera.projection = Projection::kEquirectangular;
  camera.aperture_radius = 1;  // there is no lens
  const CameraRays rays(camera, 8, 4);
  const auto looks = [&](float x, float y) { return rays.ray({x, y}, {0.9f, 0.9f}); };
  test::expect_near(looks(4, 2).d, {0, 0, -1}, 1e-6f);
  test::expect_near(looks(6, 2).d, {1, 0, 0}, 1e-6f);  // a quarter to the right
  test::expect_near(looks(2, 2).d, {-1, 0, 0}, 1e-6f);
  test::expect_near(looks(0, 2).d, {0, 0, 1}, 1e-6f);
  test::expect_near(looks(3, 0).d, {0, 1, 0}, 1e-6f);
  test::expect_near(looks(3, 4).d, {0, -1, 0}, 1e-6f);
  EXPECT_EQ(looks(4, 2).o, camera.position);
  EXPECT_FALSE(rays.has_lens());
  camera.mirrored = true;
  test::expect_near(CameraRays(camera, 8, 4).ray({6, 2}, {}).d, {-1, 0, 0}, 1e-6f);
}

TEST(CameraRays, RaysBeginAtTheNearPlane) {
  Camera camera;
  camera.position = {1, 2, 3};
  camera.target = {1, 2, -9};
  camera.near_clip = 2;
  for (const float radius : {0.0f, 0.5f}) {
    camera.aperture_radius = radius;
    const CameraRays rays(camera, 8, 4);
    for (const Vec2 pixel : {Vec2{0, 0}, Vec2{3, 4}, Vec2{8, 1}}) {
      const Ray ray = rays.ray(pixel, {0.8f, 0.3f});
      EXPECT_NEAR(ray.o.z, 1, 1e-5f);
      EXPECT_NEAR(length(ray.d), 1, 1e-5f);
      const auto seen = rays.project(ray.o + ray.d * 5);
      if (radius > 0) continue;
      ASSERT_TRUE(seen);
      EXPECT_NEAR(seen->x, pixel.x, 1e-4f);
    }
  }
}

// A quarter of a picture is that quarter of the whole one.
TEST(CameraRays, AShiftedPictureIsAWindow) {
  for (const Projection projection : {Projection::kPerspective, Projection::kOrthographic}) {
    for (const bool mirrored : {false, true}) {
      Camera camera;
      camera.projection = projection;
      camera.vertical_fov_deg = 60;
      camera.mirrored = mirrored;
      Camera part = camera;
      part.vertical_fov_deg = 2 * std::atan(0.5f * std::tan(kPi / 6)) * (180 / kPi);
      part.shift = {0.5f, -0.5f};  // the lower right one
      const CameraRays whole(camera, 16, 8), window(part, 8, 4);
      for (const Vec2 pixel : {Vec2{0, 0}, Vec2{3.25f, 1.5f}, Vec2{8, 4}}) {
        const Ray a = whole.ray({pixel.x + 8, pixel.y + 4}, {}), b = window.ray(pixel, {});
        test::expect_near(a.d, b.d, 1e-6f);
        test::expect_near(a.o, b.o, 1e-6f);
        const auto back = window.project(b.o + b.d * 3);
        ASSERT_TRUE(back);
        EXPECT_NEAR(back->x, pixel.x, 1e-4f);
        EXPECT_NEAR(back->y, pixel.y, 1e-4f);
      }
    }
  }
}

}  // namespace
}  // namespace qray
