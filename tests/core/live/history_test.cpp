#include "core/live/history.h"

#include <gtest/gtest.h>

#include "tests/support/test_scenes.h"

namespace qray {
namespace {

constexpr int kSide = 64;

std::shared_ptr<const PreparedScene> prepared(Scene scene) {
  scene.camera.position = {0, 0, 4};
  const SceneHash hash = hash_scene(scene).value();
  return prepare_scene(std::move(scene), hash, 1).value();
}

// A wall at z = 0, and a smaller one a metre before it.
std::shared_ptr<const PreparedScene> walls(bool with_front) {
  Scene scene;
  const MaterialId white = test::add_material(scene, Rgb{0.7f});
  test::add_quad(scene, white, {-9, -9, 0}, {18, 0, 0}, {0, 18, 0});
  if (with_front) test::add_quad(scene, white, {-0.5f, -0.5f, 1}, {1, 0, 0}, {0, 1, 0});
  return prepared(std::move(scene));
}

Camera camera_at(float x) {
  Camera camera;
  camera.position = {x, 0, 4};
  camera.target = {x, 0, 0};
  return camera;
}

// Metres that a pixel is wide at a distance.
float pixel_width(float distance) {
  return 2 * distance * std::tan(camera_at(0).vertical_fov_deg * kPi / 360) / kSide;
}

History ramp(int width, int height) {
  History history(static_cast<size_t>(width * height));
  for (size_t i = 0; i < history.size(); ++i)
    history[i] = {Rgb{static_cast<float>(i % static_cast<size_t>(width))}, 1, 3,
                  Rgb{static_cast<float>(i / static_cast<size_t>(width))}, 2};
  return history;
}

// A metre to the side is as many pixels of an orthographic picture near as far; a picture of all
// directions from the same place is found whole but for its edges.
TEST(History, IsFoundInOtherProjections) {
  TaskPool pool(2);
  const auto scene = walls(true);
  Camera camera = camera_at(0);
  camera.projection = Projection::kOrthographic;
  camera.height = 4;
  const ViewBuffer before = see_view(*scene, camera, kSide, kSide, pool);
  camera.position.x = camera.target.x = 5.25f * 4 / kSide;
  const ViewBuffer now = see_view(*scene, camera, kSide, kSide, pool);
  const History moved = reproject(before, ramp(kSide, kSide), now, pool);
  const int middle = kSide / 2;
  for (const auto& [x, y] : {std::pair{3, 9}, {50, 60}, {30, 1}, {middle - 5, middle}}) {
    const PixelHistory& h = moved[now.index(x, y)];  // the last: of the wall in front
    EXPECT_NEAR(h.light.r, static_cast<float>(x) + 5.25f, 1e-2);
    EXPECT_NEAR(h.samples, 3, 0.05);
  }

  camera = camera_at(0);
  camera.projection = Projection::kEquirectangular;
  const ViewBuffer around = see_view(*scene, camera, 2 * kSide, kSide, pool);
  const History same = reproject(around, ramp(2 * kSide, kSide), around, pool);
  for (int x = 1; x < 2 * kSide - 1; ++x) {
    ASSERT_NEAR(same[around.index(x, kSide / 2)].light.r, x, 1e-2);
    ASSERT_NEAR(same[around.index(x, kSide / 2)].samples, 3, 0.05);
  }
}

TEST(History, IsFoundWhereTheSurfaceWasSeenBefore) {
  TaskPool pool(2);
  const auto scene = walls(false);
  const ViewBuffer before = see_view(*scene, camera_at(0), kSide, kSide, pool);
  // By 5.25 pixels of the wall to the right: it moves as much to the left.
  const ViewBuffer now = see_view(*scene, camera_at(5.25f * pixel_width(4)), kSide, kSide, pool);
  const History moved = reproject(before, ramp(kSide, kSide), now, pool);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide - 7; ++x) {
      const PixelHistory& h = moved[now.index(x, y)];
      ASSERT_NEAR(h.light.r, static_cast<float>(x) + 5.25f, 1e-2) << x << ", " << y;
      ASSERT_NEAR(h.samples, 3, 0.05);
      ASSERT_NEAR(h.guess.r, y, 0.05);
      ASSERT_NEAR(h.guesses, 2, 1e-3);
    }
  for (int x = kSide - 4; x < kSide; ++x) {  // was not in sight
    EXPECT_EQ(moved[now.index(x, 9)].samples, 0) << x;
    EXPECT_EQ(moved[now.index(x, 9)].guesses, 0) << x;
  }
}

TEST(History, IsFoundInAnotherResolution) {
  TaskPool pool(2);
  const auto scene = walls(false);
  const ViewBuffer before = see_view(*scene, camera_at(0), kSide, kSide, pool);
  const ViewBuffer now = see_view(*scene, camera_at(0), kSide / 2, kSide / 2, pool);
  const History moved = reproject(before, ramp(kSide, kSide), now, pool);
  for (int x = 0; x < kSide / 2; ++x)
    EXPECT_NEAR(moved[now.index(x, 7)].light.r, 2 * static_cast<float>(x) + 0.5f, 1e-2);
}

TEST(History, OfWhatStoodBeforeIsLeftBehind) {
  TaskPool pool(2);
  const auto scene = walls(true);
  const ViewBuffer before = see_view(*scene, camera_at(0), kSide, kSide, pool);
  const ViewBuffer now = see_view(*scene, camera_at(0.6f), kSide, kSide, pool);
  // The front wall was black, all else white.
  History history(before.points.size());
  for (size_t i = 0; i < history.size(); ++i)
    history[i] = {Rgb{before.surfaces[i] == 1 ? 0.0f : 1.0f}, 1, 3};
  const History moved = reproject(before, history, now, pool);
  int uncovered = 0, front = 0;
  for (size_t i = 0; i < moved.size(); ++i) {
    if (moved[i].samples == 0) {
      ++uncovered;
      continue;
    }
    const bool is_front = now.surfaces[i] == 1;
    front += is_front;
    ASSERT_NEAR(moved[i].light.r, is_front ? 0 : 1, 1e-4) << i;
  }
  EXPECT_GT(uncovered, kSide);  // beside the edge of the picture, behind the front wall
  EXPECT_GT(front, 100);
}

TEST(History, OfAnotherPlaceIsNotFound) {
  TaskPool pool(2);
  const auto scene = walls(false);
  const ViewBuffer before = see_view(*scene, camera_at(0), kSide, kSide, pool);
  Camera turned = camera_at(0);
  turned.target = {0, 0, 8};  // away from the wall
  const ViewBuffer away = see_view(*scene, turned, kSide, kSide, pool);
  for (const PixelHistory& h : reproject(before, ramp(kSide, kSide), away, pool))
    ASSERT_EQ(h.samples, 0);
  const ViewBuffer far = see_view(*scene, camera_at(8), kSide, kSide, pool);
  for (const PixelHistory& h : reproject(before, ramp(kSide, kSide), far, pool))
    ASSERT_EQ(h.samples, 0);
}

TEST(History, CountsLessSeenFromNearer) {
  TaskPool pool(2);
  const auto scene = walls(false);
  const ViewBuffer before = see_view(*scene, camera_at(0), kSide, kSide, pool);
  Camera near = camera_at(0);
  near.position.z = 2;
  const ViewBuffer now = see_view(*scene, near, kSide, kSide, pool);
  const History moved = reproject(before, ramp(kSide, kSide), now, pool);
  EXPECT_NEAR(moved[now.index(kSide / 2, kSide / 2)].samples, 0.75, 0.01);
}

TEST(PixelHistory, KnowsTheMomentsOfItsSamples) {
  PixelHistory h;
  for (const float v : {1.0f, 2.0f, 6.0f}) h.add(Rgb{v});
  EXPECT_FLOAT_EQ(h.samples, 3);
  EXPECT_FLOAT_EQ(h.light.g, 3);
  EXPECT_NEAR(h.variance(), 41.0f / 3 - 9, 1e-4);
}

}  // namespace
}  // namespace qray
