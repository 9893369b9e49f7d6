// What moves in a scene over time, as glTF 2.0 has it (specification 3.11, appendix C): keys of a
// node's map and of its morph weights, and the cameras that follow. Plain data; pure.
#pragma once

#include <memory>
#include <vector>

#include "core/scene/camera.h"
#include "core/scene/transform.h"

namespace qray {

// Scale, then rotate (a quaternion x, y, z, w, made unit; zero rotates nothing), then translate.
Transform placed(Vec3 translation, const std::array<double, 4>& quaternion, Vec3 scale);

// A node under the one above it.
struct NodePose {
  // Each is empty, or has 16 numbers by columns, 3, 4 (x, y, z, w) and 3.
  std::vector<double> matrix, translation, rotation, scale;
  std::vector<double> weights;  // of morph targets

  Transform to_parent() const;
};

// A value over time. Before the first key and after the last, these hold.
struct Track {
  enum class Between { kLinear, kStep, kCubic };
  Between between = Between::kLinear;
  bool turns = false;          // quaternions: along the shorter arc, made unit
  std::vector<float> seconds;  // of the keys, rising; empty: nothing moves
  size_t width = 0;            // numbers that a value has
  std::vector<float> values;   // `width` a key; cubic: the slope into it, the value, the slope out

  std::vector<double> at(double time) const;
};

struct NodeMotion {
  Track translation, rotation, scale, weights;
  Vec3 axis;  // that `rotation` turns about where its values are degrees: of width 1

  bool moves_node() const {
    return !translation.seconds.empty() || !rotation.seconds.empty() || !scale.seconds.empty();
  }
  double end() const;  // seconds: its last key
  // What moves of `rest`, as it is then.
  NodePose at(double time, NodePose rest) const;
};

// A camera of a node, which looks along its -z with +y up. Its target is as far from it as the
// origin is, so that rounding turns the view by nothing.
Camera placed_camera(Camera lens, const Transform& to_world);

// A camera whose node moves, or one above it.
struct CameraPath {
  struct Step {
    NodePose rest;
    std::shared_ptr<const NodeMotion> motion = {};  // null: it never moves
  };
  std::vector<Step> steps;  // from the top
  Camera lens;

  Camera at(double time) const;
};

}  // namespace qray
