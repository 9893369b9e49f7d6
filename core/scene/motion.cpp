#include "core/scene/motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace qray {
namespace {

// Of a quaternion x, y, z, w.
Transform rotation_of(const std::array<double, 4>& q) {
  const double norm = std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3]));
  Transform t;
  if (!(norm > 0)) return t;
  const double x = q[0] / norm, y = q[1] / norm, z = q[2] / norm, w = q[3] / norm;
  t.rows = {{{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), 0},
             {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), 0},
             {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), 0}}};
  return t;
}

std::vector<double> quaternion(Vec3 axis, double degrees) {
  const double half = degrees * std::numbers::pi / 360;
  const double sine = std::sin(half) / double{length(axis)};
  return {sine * double{axis.x}, sine * double{axis.y}, sine * double{axis.z}, std::cos(half)};
}

// How much of two unit quaternions makes the one `u` of the way between them.
std::array<double, 2> slerp_weights(const std::vector<double>& a, const std::vector<double>& b,
                                    double u) {
  const double cosine = std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
  const double side = cosine < 0 ? -1 : 1, angle = std::acos(std::min(1.0, cosine * side));
  if (angle < 1e-4) return {1 - u, side * u};
  const double sine = std::sin(angle);
  return {std::sin((1 - u) * angle) / sine, side * std::sin(u * angle) / sine};
}

void make_unit(std::vector<double>& v) {
  const double norm = std::sqrt(std::inner_product(v.begin(), v.end(), v.begin(), 0.0));
  if (norm > 0)
    for (double& x : v) x /= norm;
}

Vec3 vec3_or(const std::vector<double>& v, float fallback) {
  if (v.empty()) return {fallback, fallback, fallback};
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

Vec3 unit_column(const Transform& t, size_t c) { return normalize(t.column(c)); }

}  // namespace

Transform placed(Vec3 translation, const std::array<double, 4>& quaternion, Vec3 scale) {
  return Transform::translation(translation)
      .after(rotation_of(quaternion).after(Transform::scaling(scale)));
}

Transform NodePose::to_parent() const {
  if (!matrix.empty()) return transform_of_columns(matrix);
  std::array<double, 4> q{0, 0, 0, 1};
  if (!rotation.empty()) std::copy_n(rotation.begin(), 4, q.begin());
  return placed(vec3_or(translation, 0), q, vec3_or(scale, 1));
}

std::vector<double> Track::at(double time) const {
  const bool cubic = between == Between::kCubic;
  // Of a cubic key, `part`: 0 the slope into it, 1 its value, 2 the slope out of it.
  const auto part_of = [&](size_t key, size_t part) {
    const auto first =
        values.begin() + static_cast<ptrdiff_t>((cubic ? 3 * key + part : key) * width);
    return std::vector<double>(first, first + static_cast<ptrdiff_t>(width));
  };
  const auto next =
      static_cast<size_t>(std::upper_bound(seconds.begin(), seconds.end(), time) - seconds.begin());
  std::vector<double> value = part_of(std::max<size_t>(next, 1) - 1, 1);
  if (next > 0 && next < seconds.size() && between != Between::kStep) {
    const size_t last = next - 1;
    const double step = double{seconds[next]} - double{seconds[last]};
    const double u = (time - double{seconds[last]}) / step;
    std::vector<double> to = part_of(next, 1);
    std::array<double, 2> weights{1 - u, u};
    if (cubic) {
      weights = {(2 * u - 3) * u * u + 1, (3 - 2 * u) * u * u};
    } else if (turns) {
      make_unit(value);
      make_unit(to);
      weights = slerp_weights(value, to, u);
    }
    for (size_t i = 0; i < width; ++i) value[i] = weights[0] * value[i] + weights[1] * to[i];
    if (cubic) {
      const std::vector<double> out = part_of(last, 2), in = part_of(next, 0);
      for (size_t i = 0; i < width; ++i)
        value[i] += step * (((u - 2) * u + 1) * u * out[i] + (u - 1) * u * u * in[i]);
    }
  }
  if (turns) make_unit(value);
  return value;
}

double NodeMotion::end() const {
  double end = 0;
  for (const Track* track : {&translation, &rotation, &scale, &weights})
    if (!track->seconds.empty()) end = std::max(end, double{track->seconds.back()});
  return end;
}

NodePose NodeMotion::at(double time, NodePose rest) const {
  if (moves_node()) rest.matrix.clear();  // glTF allows no matrix there
  if (!translation.seconds.empty()) rest.translation = translation.at(time);
  if (!rotation.seconds.empty()) rest.rotation = rotation.at(time);
  if (rotation.width == 1) rest.rotation = quaternion(axis, rest.rotation[0]);
  if (!scale.seconds.empty()) rest.scale = scale.at(time);
  if (!weights.seconds.empty()) rest.weights = weights.at(time);
  return rest;
}

Camera placed_camera(Camera lens, const Transform& to_world) {
  lens.position = to_world.column(3);
  lens.target = lens.position - unit_column(to_world, 2) * std::max(1.0f, length(lens.position));
  lens.up = unit_column(to_world, 1);
  lens.mirrored = to_world.determinant() < 0;
  return lens;
}

Camera CameraPath::at(double time) const {
  Transform to_world;
  for (const Step& step : steps)
    to_world =
        to_world.after((step.motion ? step.motion->at(time, step.rest) : step.rest).to_parent());
  return placed_camera(lens, to_world);
}

}  // namespace qray
