// A pinhole or thin-lens camera. Right-handed; the picture's rows run from the top.
#pragma once

#include <optional>

#include "core/math/ray.h"
#include "core/math/warp.h"

namespace qray {

struct Camera {
  Vec3 position{0, 0, 0};
  Vec3 target{0, 0, -1};
  Vec3 up{0, 1, 0};
  float vertical_fov_deg = 45;  // (0, 180)
  float aperture_radius = 0;    // metres; 0 = pinhole
  float focus_distance = 0;     // metres along the view axis; 0 = the target's distance
  bool mirrored = false;        // the picture's left and right are exchanged

  bool operator==(const Camera&) const = default;
};

// A Camera prepared for a picture's size. Immutable; any thread.
class CameraRays {
 public:
  CameraRays(const Camera& camera, int width, int height)
      : position_(camera.position), aperture_radius_(camera.aperture_radius) {
    const Vec3 to_target = camera.target - camera.position;
    forward_ = normalize(to_target);
    Vec3 right = normalize(cross(forward_, camera.up));
    const Vec3 up = cross(right, forward_);
    if (camera.mirrored) right = -right;
    const float half_height = std::tan(camera.vertical_fov_deg * (kPi / 360));
    const float half_width = half_height * static_cast<float>(width) / static_cast<float>(height);
    lens_x_ = right;
    lens_y_ = up;
    corner_ = forward_ - right * half_width + up * half_height;
    step_x_ = right * (2 * half_width / static_cast<float>(width));
    step_y_ = up * (-2 * half_height / static_cast<float>(height));
    focus_distance_ = camera.focus_distance > 0 ? camera.focus_distance : length(to_target);
  }

  // `pixel` in pixels from the top left corner; `u_lens` in the unit square.
  Ray ray(Vec2 pixel, Vec2 u_lens) const {
    const Vec3 d = corner_ + step_x_ * pixel.x + step_y_ * pixel.y;  // depth 1 along the axis
    if (aperture_radius_ == 0) return {position_, normalize(d)};
    const Vec2 lens = square_to_disk(u_lens) * aperture_radius_;
    const Vec3 offset = lens_x_ * lens.x + lens_y_ * lens.y;
    return {position_ + offset, normalize(d * focus_distance_ - offset)};
  }
  // The pixel (of real coordinates) that shows p through the lens' middle; none: it lies behind.
  std::optional<Vec2> project(Vec3 p) const {
    const Vec3 d = p - position_;
    const float depth = dot(d, forward_);
    if (!(depth > 0)) return std::nullopt;
    const Vec3 on_plane = d / depth - corner_;
    return Vec2{dot(on_plane, step_x_) / dot(step_x_, step_x_),
                dot(on_plane, step_y_) / dot(step_y_, step_y_)};
  }
  Vec3 position() const { return position_; }
  float pixel_angle() const { return length(step_y_); }  // radians, in the picture's middle
  bool has_lens() const { return aperture_radius_ > 0; }

 private:
  Vec3 position_, forward_, lens_x_, lens_y_, corner_, step_x_, step_y_;
  float aperture_radius_, focus_distance_;
};

}  // namespace qray
