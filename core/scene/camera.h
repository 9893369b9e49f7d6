// A camera, and the rays of its pixels. Right-handed; the picture's rows run from the top.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/math/ray.h"
#include "core/math/warp.h"

namespace qray {

enum class Projection : uint8_t {
  kPerspective,      // a pinhole or a thin lens
  kOrthographic,     // parallel rays, perhaps through a thin lens
  kEquirectangular,  // all directions: columns are longitudes, rows are latitudes. No lens
};
// In scene files and requests, by the value.
inline constexpr std::array<std::string_view, 3> kProjectionNames{"perspective", "orthographic",
                                                                  "equirectangular"};
inline std::optional<Projection> projection_named(std::string_view name) {
  const auto* const found = std::find(kProjectionNames.begin(), kProjectionNames.end(), name);
  if (found == kProjectionNames.end()) return std::nullopt;
  return static_cast<Projection>(found - kProjectionNames.begin());
}
inline std::string_view name_of(Projection projection) {
  return kProjectionNames[static_cast<size_t>(projection)];
}

struct Camera {
  Vec3 position{0, 0, 0};
  // Of an equirectangular picture, whose middle row is the horizon of `up`: what is in its middle
  // column.
  Vec3 target{0, 0, -1};
  Vec3 up{0, 1, 0};
  float vertical_fov_deg = 45;  // (0, 180)
  float aperture_radius = 0;    // metres; 0 = pinhole
  float focus_distance = 0;     // metres along the view axis; 0 = the target's distance
  bool mirrored = false;        // the picture's left and right are exchanged
  // By how much the picture's middle lies to the right of and above what the camera looks at, in
  // widths and heights of the picture. Counts unless it is equirectangular.
  Vec2 shift{0, 0};
  float near_clip = 0;  // metres along the view axis: what is nearer is not seen. Perspective alone
  Projection projection = Projection::kPerspective;
  // Of an orthographic picture, metres from its lower edge to its upper one; 0 = what the field of
  // view spans at the target.
  float height = 0;

  bool operator==(const Camera&) const = default;
};

struct CameraPath;  // core/scene/motion.h

// One of a scene's own.
struct NamedCamera {
  std::string name;
  Camera camera;                                // at rest
  std::shared_ptr<const CameraPath> path = {};  // null: it never moves
};

// What a pixel's ray stands for: a cone about it.
struct PixelCone {
  float width = 0;  // metres across, where the ray begins
  float angle = 0;  // radians, in the picture's middle
  float at(float distance) const { return width + angle * distance; }
};

// A Camera prepared for a picture's size. Immutable; any thread.
class CameraRays {
 public:
  CameraRays(const Camera& camera, int width, int height)
      : projection_(camera.projection),
        position_(camera.position),
        near_clip_(projection_ == Projection::kPerspective ? camera.near_clip : 0),
        aperture_radius_(projection_ == Projection::kEquirectangular ? 0 : camera.aperture_radius) {
    const Vec3 to_target = camera.target - camera.position;
    forward_ = normalize(to_target);
    Vec3 right = normalize(cross(forward_, camera.up));
    const Vec3 up = cross(right, forward_);
    focus_distance_ = camera.focus_distance > 0 ? camera.focus_distance : length(to_target);
    const auto columns = static_cast<float>(width), rows = static_cast<float>(height);
    if (projection_ == Projection::kEquirectangular) {
      lens_y_ = normalize(camera.up);
      forward_ = cross(lens_y_, right);
      lens_x_ = camera.mirrored ? -right : right;
      angles_ = {2 * kPi / columns, kPi / rows};
      cone_.angle = angles_.y;
      return;
    }
    if (camera.mirrored) right = -right;
    float half_height = std::tan(camera.vertical_fov_deg * (kPi / 360));
    Vec3 middle = forward_;
    if (projection_ == Projection::kOrthographic) {
      half_height = camera.height > 0 ? 0.5f * camera.height : half_height * length(to_target);
      middle = position_;
    }
    const float half_width = half_height * columns / rows;
    middle += right * (2 * half_width * camera.shift.x) + up * (2 * half_height * camera.shift.y);
    lens_x_ = right;
    lens_y_ = up;
    corner_ = middle - right * half_width + up * half_height;
    step_x_ = right * (2 * half_width / columns);
    step_y_ = up * (-2 * half_height / rows);
    (projection_ == Projection::kOrthographic ? cone_.width : cone_.angle) = length(step_y_);
    if (near_clip_ > 0) cone_.width = cone_.angle * near_clip_;
  }

  // `pixel` in pixels from the top left corner; `u_lens` in the unit square.
  Ray ray(Vec2 pixel, Vec2 u_lens) const {
    if (projection_ == Projection::kEquirectangular) return {position_, direction(pixel)};
    const Vec3 d = corner_ + step_x_ * pixel.x + step_y_ * pixel.y;  // depth 1 along the axis
    const bool parallel = projection_ == Projection::kOrthographic;  // then d is a place
    if (aperture_radius_ == 0)
      return parallel ? Ray{d, forward_} : clipped({position_, normalize(d)});
    const Vec2 lens = square_to_disk(u_lens) * aperture_radius_;
    const Vec3 offset = lens_x_ * lens.x + lens_y_ * lens.y;
    if (parallel) return {d + offset, normalize(forward_ * focus_distance_ - offset)};
    return clipped({position_ + offset, normalize(d * focus_distance_ - offset)});
  }
  // The pixel (of real coordinates) that shows p through the lens' middle; none: it lies behind.
  std::optional<Vec2> project(Vec3 p) const {
    const Vec3 d = p - position_;
    if (projection_ == Projection::kEquirectangular) return pixel_of(d);
    const float depth = dot(d, forward_);
    if (!(depth > 0)) return std::nullopt;
    const Vec3 on_plane = (projection_ == Projection::kOrthographic ? p : d / depth) - corner_;
    return Vec2{dot(on_plane, step_x_) / dot(step_x_, step_x_),
                dot(on_plane, step_y_) / dot(step_y_, step_y_)};
  }
  // From where the ray that shows p begins.
  float distance(Vec3 p) const {
    const Vec3 d = p - position_;
    return projection_ == Projection::kOrthographic ? std::abs(dot(d, forward_)) : length(d);
  }
  // Along the view's axis; of an equirectangular picture from the camera.
  float depth(Vec3 p) const {
    const Vec3 d = p - position_;
    return projection_ == Projection::kEquirectangular ? length(d) : dot(d, forward_);
  }
  Vec3 position() const { return position_; }
  PixelCone cone() const { return cone_; }
  bool has_lens() const { return aperture_radius_ > 0; }

 private:
  Ray clipped(const Ray& ray) const {
    if (near_clip_ == 0) return ray;
    return {ray.o + ray.d * (near_clip_ / dot(ray.d, forward_)), ray.d};
  }
  // Of an equirectangular picture: longitude from the middle column to the right, and the angle
  // from up.
  Vec3 direction(Vec2 pixel) const {
    const float longitude = pixel.x * angles_.x - kPi, polar = pixel.y * angles_.y;
    const float level = std::sin(polar);
    return normalize(lens_x_ * (std::sin(longitude) * level) + lens_y_ * std::cos(polar) +
                     forward_ * (std::cos(longitude) * level));
  }
  std::optional<Vec2> pixel_of(Vec3 d) const {
    const float x = dot(d, lens_x_), y = dot(d, lens_y_), z = dot(d, forward_);
    const float level = std::sqrt(x * x + z * z);
    if (level == 0 && y == 0) return std::nullopt;
    return Vec2{(std::atan2(x, z) + kPi) / angles_.x, std::atan2(level, y) / angles_.y};
  }

  Projection projection_;
  Vec3 position_, forward_, lens_x_, lens_y_, corner_, step_x_, step_y_;
  Vec2 angles_;  // radians that a column and a row span
  PixelCone cone_;
  float near_clip_, aperture_radius_, focus_distance_ = 0;
};

}  // namespace qray
