// Keys over time, and cameras that follow nodes.
#include "core/scene/motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace qray {
namespace {

using Between = Track::Between;

void expect_near(const std::vector<double>& a, const std::vector<double>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-6) << i;
}

TEST(Track, BetweenKeysAndBeyond) {
  Track track;
  track.seconds = {1, 3};
  track.width = 2;
  track.values = {10, 0, 20, 8};
  expect_near(track.at(0), {10, 0});
  expect_near(track.at(1), {10, 0});
  expect_near(track.at(1.5), {12.5, 2});
  expect_near(track.at(3), {20, 8});
  expect_near(track.at(9), {20, 8});
  track.between = Between::kStep;
  expect_near(track.at(2.999), {10, 0});
  expect_near(track.at(3), {20, 8});
}

// t^3 from 0 to 2 and its slopes are met to the rounding.
TEST(Track, CubicKeysHaveTheCurveOfTheirSlopes) {
  Track track;
  track.between = Between::kCubic;
  track.seconds = {0, 2};
  track.width = 1;
  track.values = {99, 0, 0, 12, 8, 99};
  for (const double t : {0.0, 0.3, 1.0, 1.7, 2.0}) expect_near(track.at(t), {t * t * t});
}

std::vector<float> about_y(double degrees) {
  const double half = degrees * std::numbers::pi / 360;
  return {0, static_cast<float>(std::sin(half)), 0, static_cast<float>(std::cos(half))};
}

TEST(Track, RotationsTakeTheShorterArcAtOneSpeed) {
  Track track;
  track.turns = true;
  track.seconds = {0, 1};
  track.width = 4;
  for (const double sign : {1.0, -1.0}) {  // a quaternion and its negative are the same rotation
    track.values = about_y(10);
    for (const float v : about_y(130)) track.values.push_back(static_cast<float>(sign) * v);
    for (const double u : {0.25, 0.5, 0.9}) {
      const std::vector<double> q = track.at(u);
      EXPECT_NEAR(std::abs(2 * std::atan2(q[1], q[3]) * 180 / std::numbers::pi), 10 + u * 120,
                  1e-4);
      EXPECT_NEAR(std::hypot(q[1], q[3]), 1, 1e-6);
    }
  }
  track.values = about_y(10);
  for (const float v : about_y(10)) track.values.push_back(v);
  for (const double v : track.at(0.5)) EXPECT_TRUE(std::isfinite(v));
}

TEST(CameraPath, TheNodesAboveTurnItToo) {
  CameraPath path;
  path.lens.vertical_fov_deg = 30;
  path.steps.resize(2);
  NodeMotion motion;
  Track& turn = motion.rotation;
  turn.turns = true;
  turn.width = 4;
  turn.seconds = {0, 2};
  turn.values = about_y(0);
  for (const float v : about_y(90)) turn.values.push_back(v);
  path.steps[0].motion = std::make_shared<NodeMotion>(motion);
  path.steps[1].rest.translation = {0, 0, 4};
  const Camera rest = path.at(0), turned = path.at(2), half = path.at(1);
  EXPECT_NEAR(length(rest.position - Vec3{0, 0, 4}), 0, 1e-5);
  EXPECT_NEAR(length(turned.position - Vec3{4, 0, 0}), 0, 1e-5);
  EXPECT_NEAR(length(turned.target), 0, 1e-5) << "it looks at the axis";
  EXPECT_NEAR(length(half.position - Vec3{2.828427f, 0, 2.828427f}), 0, 1e-4);
  EXPECT_EQ(turned.vertical_fov_deg, 30);
  EXPECT_FALSE(turned.mirrored);
}

TEST(NodeMotion, WhatDoesNotMoveIsAsAtRest) {
  NodeMotion motion;
  motion.scale.seconds = {0, 4};
  motion.scale.width = 3;
  motion.scale.values = {1, 1, 1, 3, 3, 3};
  NodePose rest;
  rest.translation = {5, 6, 7};
  const Transform moved = motion.at(2, rest).to_parent();
  EXPECT_NEAR(length(moved.point({1, 1, 1}) - Vec3{7, 8, 9}), 0, 1e-5);
  EXPECT_EQ(motion.end(), 4);
  EXPECT_TRUE(motion.moves_node());
}

}  // namespace
}  // namespace qray
