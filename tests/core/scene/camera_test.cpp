#include "core/scene/camera.h"

#include <gtest/gtest.h>

namespace qray {
namespace {

TEST(CameraRays, ProjectBackToTheirPixels) {
  Camera camera;
  camera.position = {1, 2, 3};
  camera.target = {-2, 1.5f, -1};
  for (const bool mirrored : {false, true}) {
    camera.mirrored = mirrored;
    const CameraRays rays(camera, 64, 48);
    for (const Vec2 pixel : {Vec2{0.5f, 0.5f}, {32, 24}, {63.5f, 3.25f}, {-7, 60}}) {
      const Ray ray = rays.ray(pixel, {0.5f, 0.5f});
      for (const float t : {0.1f, 7.0f}) {
        const std::optional<Vec2> back = rays.project(ray.o + ray.d * t);
        ASSERT_TRUE(back.has_value());
        EXPECT_NEAR(back->x, pixel.x, 1e-3f);
        EXPECT_NEAR(back->y, pixel.y, 1e-3f);
      }
      EXPECT_FALSE(rays.project(ray.o - ray.d).has_value());
    }
  }
}

}  // namespace
}  // namespace qray
