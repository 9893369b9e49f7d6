#include "core/settings/frames.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "core/math/hash.h"
#include "core/scene/validate.h"
#include "core/settings/job_settings.h"

namespace qray {
namespace {

constexpr float kLeastLength = 1e-6f;

// About a unit axis through the origin (Rodrigues).
Vec3 turned(Vec3 v, Vec3 axis, double radians) {
  const auto c = static_cast<float>(std::cos(radians)), s = static_cast<float>(std::sin(radians));
  return v * c + cross(axis, v) * s + axis * (dot(axis, v) * (1 - c));
}

Camera camera_of_request(const JobRequest& request, const Scene& scene) {
  return camera_of(camera_request(request).value_or(CameraRequest()), scene.camera);
}

Result<std::vector<NamedCamera>> turntable_of(const JobRequest& request, const Camera& camera) {
  const std::optional<Vector3> center = request.given(field::kCenter);
  const std::optional<Vector3> given_axis = request.given(field::kAxis);
  const Vec3 middle = center ? vec3_of(*center) : camera.target;
  Vec3 axis = given_axis ? vec3_of(*given_axis) : camera.up;
  if (!(length(axis) > kLeastLength))
    return Error{ErrorCode::kInvalid, "expected a direction, got the zero vector", "/frames/axis"};
  axis = normalize(axis);
  const Vec3 arm = camera.position - middle;
  const auto is_turned = [axis](Vec3 v) {
    return length(cross(axis, v)) > kLeastLength * std::max(1.0f, length(v));
  };
  if (!is_turned(arm) && !is_turned(camera.target - middle))
    return Error{ErrorCode::kInvalid,
                 "expected another axis than the line of sight: about that, the picture only rolls",
                 "/frames/axis"};
  const int count = request.get(field::kTurntable);
  const double degrees = request.given(field::kDegrees).value_or(360);
  const double step = std::abs(degrees) < 360 ? degrees / std::max(1, count - 1) : degrees / count;
  std::vector<NamedCamera> frames;
  for (int i = 0; i < count; ++i) {
    const double radians = i * step * (std::numbers::pi / 180);
    Camera view = camera;
    if (i == 0) {  // to the bit
      frames.push_back({"", view});
      continue;
    }
    view.position = middle + turned(arm, axis, radians);
    view.target = middle + turned(camera.target - middle, axis, radians);
    view.up = turned(camera.up, axis, radians);
    frames.push_back({"", view});
  }
  return frames;
}

Error no_such_camera(size_t index, const std::string& name, const Scene& scene) {
  std::string known;
  for (const NamedCamera& own : scene.cameras) known += (known.empty() ? "" : ", ") + own.name;
  return {ErrorCode::kInvalid,
          "the scene has no camera '" + name +
              "': " + (known.empty() ? "it names none" : "expected one of " + known),
          "/frames/cameras/" + std::to_string(index)};
}

}  // namespace

bool asks_for_frames(const JobRequest& request) {
  return request.given(field::kTurntable) || request.given(field::kCameras);
}

Status check_frames(const JobRequest& request) {
  const auto wrong = [](const std::string& field, std::string text) {
    return Error{ErrorCode::kInvalid, std::move(text), "/frames/" + field};
  };
  const bool turntable = request.given(field::kTurntable).has_value();
  if (turntable && request.given(field::kCameras))
    return wrong("cameras", "expected turntable or cameras, got both");
  for (const auto& [path, value] : request.values()) {
    if (!path.starts_with("frames/")) continue;
    const std::string name = path.substr(std::string("frames/").size());
    if (!asks_for_frames(request))
      return wrong(name, "expected turntable or cameras beside it, got neither");
    if (!turntable && (name == "center" || name == "axis" || name == "degrees"))
      return wrong(name, "expected turntable beside it, got cameras");
  }
  return {};
}

std::optional<int> frame_count(const JobRequest& request) {
  if (const std::optional<int> count = request.given(field::kTurntable)) return count;
  const std::optional<Cameras> cameras = request.given(field::kCameras);
  if (!cameras) return 1;
  for (const CameraChoice& choice : *cameras)
    if (choice.name == "*") return std::nullopt;
  return static_cast<int>(cameras->size());
}

void name_cameras(JobRequest& request, const Scene& scene) {
  const std::optional<Cameras> cameras = request.given(field::kCameras);
  if (!cameras) return;
  Cameras named;
  for (const CameraChoice& choice : *cameras) {
    if (choice.name != "*" || scene.cameras.empty())
      named.push_back(choice);
    else
      for (const NamedCamera& own : scene.cameras) named.push_back({own.name, {}});
  }
  request.set(field::kCameras, std::move(named));
}

Result<std::vector<NamedCamera>> frames_of(const JobRequest& asked, const Scene& scene) {
  JobRequest request = asked;
  name_cameras(request, scene);
  const Camera camera = camera_of_request(request, scene);
  if (request.given(field::kTurntable)) return turntable_of(request, camera);
  const std::optional<Cameras> cameras = request.given(field::kCameras);
  if (!cameras) return std::vector<NamedCamera>{{"", camera}};
  std::vector<NamedCamera> frames;
  for (size_t i = 0; i < cameras->size(); ++i) {
    const CameraChoice& choice = (*cameras)[i];
    const Camera* own = choice.name.empty() ? nullptr : scene.find_camera(choice.name);
    if (!choice.name.empty() && !own) return no_such_camera(i, choice.name, scene);
    frames.push_back({choice.name, own ? *own : camera_of(choice.camera, camera)});
    if (const Status good = validate_camera(frames.back().camera); !good.ok()) {
      const std::string place = good.error().where.substr(std::string("/camera").size());
      return Error{good.error().code, good.error().message,
                   "/frames/cameras/" + std::to_string(i) + place};
    }
  }
  if (frames.empty() || frames.size() > size_t{kMaxFrames})
    return Error{ErrorCode::kInvalid,
                 "expected 1.." + std::to_string(kMaxFrames) + " cameras, got " +
                     std::to_string(frames.size()),
                 "/frames/cameras"};
  return frames;
}

std::string frame_file_name(int frame, const std::string& format) {
  char name[32];
  std::snprintf(name, sizeof name, "frame-%04d.", frame);
  return name + format;
}

std::vector<int> spread_order(int count) {
  const int bits = std::bit_width(static_cast<unsigned>(std::max(1, count - 1)));
  std::vector<int> order;
  for (unsigned i = 0; i < (1u << bits); ++i) {
    unsigned reversed = 0;
    for (int b = 0; b < bits; ++b) reversed |= (i >> b & 1u) << (bits - 1 - b);
    if (static_cast<int>(reversed) < count) order.push_back(static_cast<int>(reversed));
  }
  return order;
}

RenderSettings frame_settings(const JobRequest& request, RenderSettings settings,
                              const std::vector<NamedCamera>& frames, int frame) {
  settings.camera = frames[static_cast<size_t>(frame)].camera;
  if (frame > 0 && request.get(field::kSeeds) != "one")
    settings.seed = mix64(settings.seed + static_cast<uint64_t>(frame));
  return settings;
}

}  // namespace qray
