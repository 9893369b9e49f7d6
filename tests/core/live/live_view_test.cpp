#include "core/live/live_view.h"

#include <gtest/gtest.h>

#include "core/live/lights.h"
#include "core/recover/included_networks.h"
#include "tests/support/render.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

class Hands final : public Clock {
 public:
  double seconds() const override { return now; }
  double now = 0;
};

struct Walk {
  explicit Walk(const std::string& method, int threads = 2, const std::string& name = "cornell-box",
                double paths_per_block = 4, uint64_t seed = 1, Pixels pixels = Pixels::kByNoise,
                bool gate = true)
      : scene(test::included_scene(name)), pool(threads) {
    settings = {test::small_settings(method, 64, 1, seed), 0.1, paths_per_block};
    settings.render.pixels = pixels;
    settings.render.gate = gate;
    view = std::make_unique<LiveView>(
        scene, settings, make_guide(method, scene->guide_setup(settings.render)).value(),
        included_network("default").value(), pool, clock);
  }
  Camera moved(float x) const {
    Camera camera = scene->scene.camera;
    camera.position.x += x;
    return camera;
  }
  LiveFrame next() { return view->next_frame().value(); }

  std::shared_ptr<const PreparedScene> scene;
  TaskPool pool;
  Hands clock;
  LiveSettings settings;
  std::unique_ptr<LiveView> view;
};

// Rests until nothing of earlier views is in the picture.
LiveFrame still_frame(Walk& walk) {
  LiveFrame frame = walk.next();
  for (int i = 0; i < 8 * kSamplesWithoutMoved && frame.stage != LiveStage::kStill; ++i)
    frame = walk.next();
  EXPECT_EQ(frame.stage, LiveStage::kStill);
  return frame;
}

constexpr LiveSwitches kSamplesAlone{.learning = true, .recovery = false, .reprojection = true};

TEST(LiveView, AtRestWithoutRecoveryShowsTheVeryPictureOfAJobOfItsSamples) {
  Walk walk("none");
  walk.view->set_switches(kSamplesAlone);
  const LiveFrame frame = still_frame(walk);
  EXPECT_EQ(frame.samples_per_pixel, kSamplesWithoutMoved);
  RenderSettings settings = test::small_settings("none", 64, kSamplesWithoutMoved);
  settings.passes.assign(kSamplesWithoutMoved, 1);  // a job's own are larger
  const Image job = test::render(*walk.scene, settings).image;
  EXPECT_TRUE(std::ranges::equal(frame.picture.data(), job.data()));
}

TEST(LiveView, AnOpenGateAsksTheGuideFromTheFirstFrameOn) {
  for (const bool gate : {true, false}) {
    Walk walk("adaptive", 2, "cornell-box", 4, 1, Pixels::kByNoise, gate);
    EXPECT_EQ(walk.next().guided, !gate) << "moving";
    EXPECT_EQ(walk.next().guided, !gate) << "at rest: the first samples are the control";
  }
}

// With a guide the samples are others, as it learns at another pace, but no worse.
TEST(LiveView, AtRestErrsNoMoreThanAJobOfItsSamples) {
  constexpr int kSamples = kSamplesWithoutMoved, kSeeds = 6;
  RenderSettings settings = test::small_settings("none", 64, 1024, 1000);
  const auto scene = test::included_scene("cornell-box");
  const Image reference = test::render(*scene, settings).image;
  double live = 0, job = 0;
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    settings = test::small_settings("adaptive", 64, kSamples, seed);
    job += relmse(test::render(*scene, settings).image, reference);
    Walk walk("adaptive", 2, "cornell-box", 16, seed);
    walk.view->set_switches(kSamplesAlone);
    const LiveFrame frame = still_frame(walk);
    ASSERT_EQ(frame.samples_per_pixel, kSamples);
    live += relmse(frame.picture, reference);
  }
  EXPECT_LT(live, 1.1 * job) << live / job;
}

TEST(LiveView, AtRestItsSamplesDisplaceWhatWasSeenBefore) {
  Walk walk("none");
  EXPECT_EQ(walk.next().stage, LiveStage::kMoving);
  EXPECT_EQ(walk.next().stage, LiveStage::kSettling);
  EXPECT_EQ(still_frame(walk).stage, LiveStage::kStill);
  walk.view->set_camera(walk.moved(0.01f));
  EXPECT_EQ(walk.next().stage, LiveStage::kMoving);
  EXPECT_EQ(walk.next().stage, LiveStage::kSettling);
}

// From a walk to a picture that is nearly exact, there is no moment at which it becomes worse, and
// none while samples are few at which they alone would have been better.
TEST(LiveView, AtRestThePictureOnlyGetsBetter) {
  RenderSettings settings = test::small_settings("none", 64, 2048, 1000);
  const auto scene = test::included_scene("cornell-box");
  Walk walk("none");
  for (int i = 8; i >= 0; --i) {
    walk.view->set_camera(walk.moved(0.004f * static_cast<float>(i)));
    walk.next();
  }
  const Image reference = test::render(*scene, settings).image;
  double before = std::numeric_limits<double>::infinity();
  int samples = 0;
  for (const int wanted : {1, 4, 16, 64, 256}) {
    LiveFrame frame;
    for (; samples < wanted; ++samples) frame = walk.next();
    settings.passes.assign(static_cast<size_t>(samples), 1);
    settings.samples = samples;
    settings.seed = 1;
    const double job = relmse(test::render(*scene, settings).image, reference);
    const double error = relmse(frame.picture, reference);
    EXPECT_LT(error, 1.05 * before) << samples << " samples";
    if (samples <= 64) {
      EXPECT_LT(error, 1.25 * job) << samples << " samples";
    }
    before = error;
  }
}

// A frame whose time was too short for all pixels is followed by one of full size.
TEST(LiveView, IsSeenInFullSizeOnceItRests) {
  SteadyClock clock;
  const auto scene = test::included_scene("cornell-box");
  TaskPool pool(1);
  LiveSettings settings{test::small_settings("none", 256, 1), 1e-4, 0};
  LiveView view(scene, settings, nullptr, included_network("default").value(), pool, clock);
  LiveFrame frame;
  for (int i = 0; i < 12; ++i) {
    Camera camera = scene->scene.camera;
    camera.position.x += 0.01f * static_cast<float>(i);
    view.set_camera(camera);
    frame = *view.next_frame();
  }
  EXPECT_LT(frame.scale, 1);
  EXPECT_EQ(view.next_frame()->scale, 1);
}

// Frames of a fixed number of samples, bit by bit.
TEST(LiveView, IsTheSameForAnyNumberOfThreads) {
  Walk one("adaptive", 1), three("adaptive", 3);
  for (int i = 0; i < 12; ++i) {
    const float x = 0.01f * static_cast<float>(std::min(i, 8));
    one.view->set_camera(one.moved(x));
    three.view->set_camera(three.moved(x));
    const LiveFrame a = one.next(), b = three.next();
    ASSERT_TRUE(std::ranges::equal(a.picture.data(), b.picture.data())) << "frame " << i;
    EXPECT_EQ(a.rays, b.rays);
  }
  EXPECT_GT(one.view->guide()->stats().samples_seen, 10'000u);
  EXPECT_EQ(one.view->guide()->stats().samples_seen, three.view->guide()->stats().samples_seen);
}

// A block of 2 x 2 pixels that gets four samples a frame gives each of its pixels one.
TEST(LiveView, PixelsOfABlockTakeTurns) {
  Walk all("none", 2, "cornell-box", 4, 1, Pixels::kAll);
  Walk quarter("none", 2, "cornell-box", 4, 1, Pixels::kQuarter);
  for (Walk* walk : {&all, &quarter}) walk->view->set_switches({false, false, false});
  for (int i = 0; i < 3; ++i) {
    for (Walk* walk : {&all, &quarter})
      walk->view->set_camera(walk->moved(0.01f * static_cast<float>(i)));
    const LiveFrame a = all.next(), b = quarter.next();
    EXPECT_EQ(a.paths, 64u * 64u);
    EXPECT_EQ(b.paths, 64u * 64u);
    EXPECT_TRUE(std::ranges::equal(a.picture.data(), b.picture.data())) << "frame " << i;
  }
}

// Where the camera turns to what it has not seen, there are more samples than where it has.
TEST(LiveView, AdaptivePixelsAreThoseOfWhichLittleIsKnown) {
  const auto turned_to_the_side = [](Pixels pixels) {
    Walk walk("none", 2, "cornell-box", 4, 1, pixels);
    for (int i = 0; i < 6; ++i) {
      walk.view->set_camera(walk.moved(0.001f * static_cast<float>(i)));
      walk.next();
    }
    Camera turned = walk.scene->scene.camera;
    turned.target.x += 0.3f;
    walk.view->set_camera(turned);
    return walk.next();
  };
  const LiveFrame even = turned_to_the_side(Pixels::kQuarter);
  const LiveFrame more = turned_to_the_side(Pixels::kByNoise);
  EXPECT_EQ(even.paths, 64u * 64u);
  EXPECT_NEAR(static_cast<double>(more.paths), 64.0 * 64, 64);  // as many in all
  EXPECT_FALSE(std::ranges::equal(even.picture.data(), more.picture.data()));
}

TEST(LiveView, EarlierFramesMakeAPictureBetter) {
  RenderSettings settings = test::small_settings("none", 64, 256, 9);
  settings.camera = Walk("none").moved(0.004f * 12);
  const Image reference = test::render(*test::included_scene("cornell-box"), settings).image;
  const auto error_with = [&](LiveSwitches switches) {
    Walk walk("none");
    walk.view->set_switches(switches);
    LiveFrame frame;
    for (int i = 0; i <= 12; ++i) {
      walk.view->set_camera(walk.moved(0.004f * static_cast<float>(i)));
      frame = walk.next();
    }
    return relmse(frame.picture, reference);
  };
  const double plain = error_with({false, false, false});
  const double reprojected = error_with({false, false, true});
  const double recovered = error_with({false, true, false});
  EXPECT_LT(reprojected, plain / 2);
  EXPECT_LT(recovered, plain / 2);
  EXPECT_LT(error_with({false, true, true}), plain / 4);
}

TEST(LiveView, ALightSwitchedOffLeavesNothing) {
  Walk walk("adaptive");
  for (int i = 0; i < 6; ++i) walk.next();
  const std::vector<float> off(light_names(walk.scene->scene).size(), 0.0f);
  ASSERT_FALSE(off.empty());
  walk.view->set_scene(with_lights(walk.scene, off).value());
  for (int i = 0; i < 3; ++i) {
    const LiveFrame dark = walk.next();
    for (const float v : dark.picture.data()) ASSERT_EQ(v, 0);
  }
}

TEST(FrameBudget, WhatBeginsAnewIsAsLargeAsPathsForAllItsPixelsAllow) {
  FrameBudget budget(0.1);
  for (int i = 0; i < 50; ++i) budget.sampled(10'000, 0.1);
  for (const double side : {64.0, 128.0, 256.0, 400.0}) {
    budget.begin_anew(side * side);
    const double scale = budget.scale();
    EXPECT_LE(sqr(scale * side), 10'100) << side;
    EXPECT_GT(sqr(scale * side), side < 100 ? 4000 : 10'000 / 2.0) << side;
  }
}

TEST(LiveView, ACutShowsNothingOfBefore) {
  Walk walk("none");
  for (int i = 0; i < 4; ++i) walk.next();
  Camera back = walk.scene->scene.camera;
  back.target = back.position * 2 - back.target;
  walk.view->set_camera(back);
  const LiveFrame cut = walk.next();
  EXPECT_EQ(cut.stage, LiveStage::kMoving);
  EXPECT_LE(cut.samples_per_pixel, static_cast<double>(cut.paths) / (64 * 64));
}

TEST(LiveView, KeepsToItsBudget) {
  SteadyClock clock;
  const auto scene = test::included_scene("cornell-box");
  TaskPool pool(2);
  LiveSettings settings{test::small_settings("none", 128, 1), 0.05, 0};
  LiveView view(scene, settings, nullptr, included_network("default").value(), pool, clock);
  uint64_t paths = 0;
  for (int i = 0; i < 10; ++i) {
    Camera camera = scene->scene.camera;
    camera.position.x += 0.01f * static_cast<float>(i);
    view.set_camera(camera);
    paths += view.next_frame()->paths;
  }
  EXPECT_GT(paths, 10 * 64 * 64 / 8u);
}

TEST(LiveView, StopsWhenTold) {
  Walk walk("none");
  std::stop_source stop;
  stop.request_stop();
  EXPECT_FALSE(walk.view->next_frame(stop.get_token()).has_value());
}

TEST(LightNames, AreOfAllKindsAndTheirFactorsCount) {
  Scene scene = test::room();
  scene.lights.push_back({});
  scene.environment.radiance = Rgb{1.0f};
  const std::vector<std::string> names = light_names(scene);
  EXPECT_EQ(names, (std::vector<std::string>{"m2", "point light 0", "environment"}));
  const float factors[] = {0.5f, 0, 2};
  const auto before = test::prepare(scene);
  const auto changed = with_lights(before, factors).value();
  EXPECT_EQ(changed->scene.materials[2].emission.value.r, 10);
  EXPECT_TRUE(changed->scene.lights[0].intensity.is_black());
  EXPECT_EQ(changed->scene.environment.radiance.g, 2);
  EXPECT_FALSE(changed->hash.lights == before->hash.lights);
  EXPECT_TRUE(changed->hash.geometry == before->hash.geometry);
  EXPECT_EQ(changed->hash.lights, hash_scene(changed->scene).value().lights);
  EXPECT_EQ(changed->accel, before->accel);
}

}  // namespace
}  // namespace qray
