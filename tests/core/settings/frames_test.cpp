#include "core/settings/frames.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "core/scene/motion.h"
#include "core/settings/job_settings.h"

namespace qray {
namespace {

Scene scene_with_cameras() {
  Scene scene;
  scene.camera.position = {0, 1, 4};
  scene.camera.target = {0, 1, 0};
  for (const char* name : {"front", "side", "front"}) {
    Camera camera = scene.camera;
    camera.position.x = static_cast<float>(scene.cameras.size()) + 1;
    scene.add_camera(name, camera);
  }
  return scene;
}

std::vector<JobFrame> frames(const JobRequest& request) {
  const auto made = frames_of(request, scene_with_cameras());
  EXPECT_TRUE(made.ok()) << made.error().text();
  return made.ok() ? made.value() : std::vector<JobFrame>();
}

std::string fault(const JobRequest& request) {
  const auto made = frames_of(request, scene_with_cameras());
  return made.ok() ? "" : made.error().where + ": " + made.error().message;
}

TEST(Frames, AJobWithoutThemHasOne) {
  JobRequest request;
  request.set("camera/vertical_fov_deg", 30.0);
  ASSERT_EQ(frames(request).size(), 1u);
  EXPECT_EQ(frames(request)[0].camera.vertical_fov_deg, 30);
  EXPECT_FALSE(asks_for_frames(request));
}

TEST(Frames, ATurntableKeepsItsDistanceAndLooksAtTheSamePoint) {
  JobRequest request;
  request.set(field::kTurntable, 8);
  const std::vector<JobFrame> all = frames(request);
  ASSERT_EQ(all.size(), 8u);
  EXPECT_EQ(all[0].camera, scene_with_cameras().camera);
  for (const JobFrame& frame : all) {
    EXPECT_NEAR(length(frame.camera.position - Vec3{0, 1, 0}), 4, 1e-5);
    EXPECT_NEAR(length(frame.camera.target - Vec3{0, 1, 0}), 0, 1e-5);
  }
  // A quarter of the circle, seen from above against the clock.
  EXPECT_NEAR(length(all[2].camera.position - Vec3{4, 1, 0}), 0, 1e-5);
}

TEST(Frames, AnArcEndsWhereItIsSaidAndACircleOneStepBefore) {
  JobRequest request;
  request.set(field::kTurntable, 3);
  request.set(field::kDegrees, -90.0);
  EXPECT_NEAR(length(frames(request)[2].camera.position - Vec3{-4, 1, 0}), 0, 1e-5);
  request.set(field::kCenter, Vector3{0, 1, 2});
  EXPECT_NEAR(length(frames(request)[2].camera.position - Vec3{-2, 1, 2}), 0, 1e-5);
  request.set(field::kAxis, Vector3{0, 0, 1});
  EXPECT_EQ(fault(request).substr(0, 14), "/frames/axis: ");
}

TEST(Frames, CamerasAreTheScenesByNameOrTheRequests) {
  JobRequest request;
  CameraRequest own;
  own.position = {{7, 1, 0}};
  request.set(field::kCameras, Cameras{{"side", {}}, {"", own}, {"front-2", {}}});
  const std::vector<JobFrame> all = frames(request);
  ASSERT_EQ(all.size(), 3u);
  EXPECT_EQ(all[0].name, "side");
  EXPECT_EQ(all[0].camera.position.x, 2);
  EXPECT_EQ(all[1].camera.position.x, 7);
  EXPECT_EQ(all[1].camera.target, (Vec3{0, 1, 0}));
  EXPECT_EQ(all[2].camera.position.x, 3);
  request.set(field::kCameras, Cameras{{"front", {}}, {"back", {}}});
  EXPECT_EQ(fault(request),
            "/frames/cameras/1: the scene has no camera 'back': expected one of front, side, "
            "front-2");
}

TEST(Frames, AStarIsEachOfTheScenesCameras) {
  JobRequest request;
  request.set(field::kCameras, Cameras{{"*", {}}});
  EXPECT_EQ(frame_count(request), std::nullopt);
  EXPECT_EQ(frames(request).size(), 3u);
  complete_frames(request, scene_with_cameras());
  EXPECT_EQ(frame_count(request), 3);
  EXPECT_EQ((*request.given(field::kCameras))[2].name, "front-2");
}

TEST(Frames, FieldsThatDoNotGoTogetherAreRefused) {
  JobRequest request;
  request.set(field::kDegrees, 90.0);
  EXPECT_FALSE(check_frames(request).ok());
  request.set(field::kTurntable, 4);
  EXPECT_TRUE(check_frames(request).ok());
  request.set(field::kCameras, Cameras{{"front", {}}});
  EXPECT_FALSE(check_frames(request).ok());
  request.clear(field::kTurntable);
  EXPECT_EQ(check_frames(request).error().where, "/frames/degrees");
}

TEST(Frames, TheOrderHasEachOnceAndSpreads) {
  EXPECT_EQ(spread_order(1), std::vector<int>{0});
  EXPECT_EQ(spread_order(8), (std::vector<int>{0, 4, 2, 6, 1, 5, 3, 7}));
  for (const int count : {2, 3, 5, 36, 100}) {
    std::vector<int> order = spread_order(count), all(static_cast<size_t>(count));
    // After the first quarter none of a circle's frames is further from one of these than a
    // quarter.
    const int head = std::max(1, count / 4);
    for (int frame = 0; frame < count; ++frame) {
      int nearest = count;
      for (int i = 0; i < head; ++i) {
        const int apart = std::abs(order[static_cast<size_t>(i)] - frame);
        nearest = std::min({nearest, apart, count - apart});
      }
      EXPECT_LE(nearest, std::max(1, (count + 1) / 2 / std::min(2, head))) << count;
    }
    std::sort(order.begin(), order.end());
    std::iota(all.begin(), all.end(), 0);
    EXPECT_EQ(order, all);
  }
}

TEST(Frames, SeedsAreIndependentUnlessOnePatternIsAskedFor) {
  JobRequest request;
  request.set(field::kTurntable, 36);
  const std::vector<JobFrame> all = frames(request);
  RenderSettings settings;
  settings.seed = 5;
  std::set<uint64_t> seeds;
  for (int i = 0; i < 36; ++i) seeds.insert(frame_settings(request, settings, all, i).seed);
  EXPECT_EQ(seeds.size(), 36u);
  EXPECT_TRUE(seeds.contains(5));  // the first frame's is the job's
  request.set(field::kSeeds, "one");
  for (int i = 0; i < 36; ++i) EXPECT_EQ(frame_settings(request, settings, all, i).seed, 5u);
}

TEST(Frames, TimeThatBoundsNoiseIsSharedByThem) {
  JobRequest request;
  request.set(field::kTurntable, 36);
  request.set(field::kNoise, 0.1);
  complete_budget(request, 3600);
  EXPECT_EQ(request.given(field::kSeconds), 100.0);
}

Scene moving_scene() {
  Scene scene = scene_with_cameras();
  auto path = std::make_shared<CameraPath>();
  path->lens.vertical_fov_deg = 40;
  path->steps.resize(1);
  NodeMotion motion;
  Track& track = motion.translation;
  track.seconds = {0, 2};
  track.width = 3;
  track.values = {0, 0, 4, 2, 0, 4};
  path->steps[0].motion = std::make_shared<NodeMotion>(motion);
  scene.camera = path->at(0);
  scene.camera_path = path;
  scene.motion_seconds = 2;
  return scene;
}

TEST(Frames, AnAnimationHasAFrameAtEachOfItsTimes) {
  const Scene scene = moving_scene();
  JobRequest request;
  request.set(field::kAnimation, 2.0);
  request.set("camera/vertical_fov_deg", 30.0);
  EXPECT_FALSE(frame_count(request));
  const std::vector<JobFrame> all = frames_of(request, scene).value();
  ASSERT_EQ(all.size(), 5u);
  EXPECT_EQ(all[0].seconds, 0);
  EXPECT_EQ(all[3].seconds, 1.5);
  EXPECT_NEAR(all[3].camera.position.x, 1.5, 1e-6);
  EXPECT_EQ(all[3].camera.vertical_fov_deg, 30) << "what the job says counts";
  complete_frames(request, scene);
  EXPECT_EQ(frame_count(request), 5);
  request.set(field::kFrom, 0.5);
  request.set(field::kTo, 1.4);
  EXPECT_EQ(frame_count(request), 2);
  EXPECT_EQ(frames_of(request, scene).value().back().seconds, 1);
  // Another of the scene's cameras, which stands.
  request.set(field::kCameras, Cameras{{"side", {}}});
  EXPECT_EQ(camera_name(request, 1), "side");
  const std::vector<JobFrame> others = frames_of(request, scene).value();
  for (const JobFrame& frame : others) {
    EXPECT_EQ(frame.name, "side");
    EXPECT_EQ(frame.camera.position, scene.find_camera("side")->camera.position);
  }
}

TEST(Frames, FaultsOfAnAnimation) {
  JobRequest request;
  request.set(field::kAnimation, 24.0);
  EXPECT_EQ(fault(request),
            "/frames/animation: expected a scene that moves: its file says nothing of it");
  request.set(field::kAnimation, 1000.0);
  EXPECT_EQ(frames_of(request, moving_scene()).error().message,
            "expected 1..1000 frames from its beginning to its end, got 2001");
  request.set(field::kFrom, 3.0);
  EXPECT_EQ(frames_of(request, moving_scene()).error().message,
            "expected 1..1000 frames from its beginning to its end, got 0");
  request.set(field::kTo, 2.0);
  EXPECT_EQ(check_frames(request).error().where, "/frames/to");
  request.clear(field::kTo);
  request.set(field::kCameras, Cameras{{"*", {}}});
  EXPECT_EQ(check_frames(request).error().where, "/frames/cameras");
  request.clear(field::kCameras);
  request.set(field::kTurntable, 3);
  EXPECT_EQ(check_frames(request).error().message, "expected turntable or animation, got both");
  request.clear(field::kAnimation);
  EXPECT_EQ(check_frames(request).error().message, "expected animation beside it");
}

}  // namespace
}  // namespace qray
