#include "core/settings/frames.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "core/math/hash.h"
#include "core/scene/motion.h"
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

Camera camera_of_request(const JobRequest& request, const Camera& own) {
  return camera_of(camera_request(request).value_or(CameraRequest()), own);
}

// So much of a frame may be missing at an animation's end.
constexpr double kFrameSlack = 1e-3;

std::optional<int> animation_count(const JobRequest& request) {
  const std::optional<double> to = request.given(field::kTo);
  if (!to) return std::nullopt;
  const double seconds = *to - request.given(field::kFrom).value_or(0);
  const double last = std::floor(seconds * request.get(field::kAnimation) + kFrameSlack);
  return static_cast<int>(std::clamp(last, -1.0, 1e9)) + 1;
}

Result<std::vector<JobFrame>> turntable_of(const JobRequest& request, const Camera& camera) {
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
  std::vector<JobFrame> frames;
  for (int i = 0; i < count; ++i) {
    const double radians = i * step * (std::numbers::pi / 180);
    Camera view = camera;
    if (i == 0) {  // to the bit
      frames.push_back({"", view, {}});
      continue;
    }
    view.position = middle + turned(arm, axis, radians);
    view.target = middle + turned(camera.target - middle, axis, radians);
    view.up = turned(camera.up, axis, radians);
    frames.push_back({"", view, {}});
  }
  return frames;
}

Error wrong_field(const std::string& name, std::string text) {
  return {ErrorCode::kInvalid, std::move(text), "/frames/" + name};
}

Error no_such_camera(size_t index, const std::string& name, const Scene& scene) {
  std::string known;
  for (const NamedCamera& own : scene.cameras) known += (known.empty() ? "" : ", ") + own.name;
  return {ErrorCode::kInvalid,
          "the scene has no camera '" + name +
              "': " + (known.empty() ? "it names none" : "expected one of " + known),
          "/frames/cameras/" + std::to_string(index)};
}

// pre: complete_frames().
Result<std::vector<JobFrame>> animation_of(const JobRequest& request, const Scene& scene) {
  if (scene.motion_seconds == 0)
    return wrong_field("animation", "expected a scene that moves: its file says nothing of it");
  const int count = animation_count(request).value_or(0);
  if (count < 1 || count > kMaxFrames)
    return wrong_field("animation", "expected 1.." + std::to_string(kMaxFrames) +
                                        " frames from its beginning to its end, got " +
                                        std::to_string(count));
  const std::string name = camera_name(request, 0);
  const NamedCamera* own = name.empty() ? nullptr : scene.find_camera(name);
  if (!name.empty() && !own) return no_such_camera(0, name, scene);
  const CameraPath* path = own ? own->path.get() : scene.camera_path.get();
  const Camera rest = own ? own->camera : scene.camera;
  std::vector<JobFrame> frames;
  for (int i = 0; i < count; ++i) {
    const double seconds =
        request.given(field::kFrom).value_or(0) + i / request.get(field::kAnimation);
    const Camera camera = camera_of_request(request, path ? path->at(seconds) : rest);
    if (const Status good = validate_camera(camera, ""); !good.ok())
      return wrong_field("animation", "after " + std::to_string(seconds) + " s the camera's " +
                                          good.error().where.substr(1) + ": " +
                                          good.error().message);
    frames.push_back({name, camera, seconds});
  }
  return frames;
}

}  // namespace

bool asks_for_frames(const JobRequest& request) {
  return request.given(field::kTurntable) || request.given(field::kCameras) ||
         request.given(field::kAnimation);
}

Status check_frames(const JobRequest& request) {
  const bool turns = request.given(field::kTurntable).has_value(),
             moves = request.given(field::kAnimation).has_value();
  const std::optional<Cameras> cameras = request.given(field::kCameras);
  if (turns && cameras) return wrong_field("cameras", "expected turntable or cameras, got both");
  if (turns && moves) return wrong_field("animation", "expected turntable or animation, got both");
  if (moves && cameras &&
      (cameras->size() != 1 || cameras->front().name == "*" || cameras->front().name.empty()))
    return wrong_field("cameras", "expected the name of one camera beside animation");
  for (const auto& [path, value] : request.values()) {
    if (!path.starts_with("frames/")) continue;
    const std::string name = path.substr(std::string("frames/").size());
    if (!asks_for_frames(request))
      return wrong_field(name, "expected turntable, cameras or animation beside it, got none");
    if (!turns && (name == "center" || name == "axis" || name == "degrees"))
      return wrong_field(name, "expected turntable beside it");
    if (!moves && (name == "from" || name == "to"))
      return wrong_field(name, "expected animation beside it");
  }
  const double from = request.given(field::kFrom).value_or(0);
  if (request.given(field::kTo).value_or(from) < from)
    return wrong_field("to", "expected a time from frames/from on");
  return {};
}

std::optional<int> frame_count(const JobRequest& request) {
  if (const std::optional<int> count = request.given(field::kTurntable)) return count;
  if (request.given(field::kAnimation)) return animation_count(request);
  const std::optional<Cameras> cameras = request.given(field::kCameras);
  if (!cameras) return 1;
  for (const CameraChoice& choice : *cameras)
    if (choice.name == "*") return std::nullopt;
  return static_cast<int>(cameras->size());
}

void complete_frames(JobRequest& request, const Scene& scene) {
  if (request.given(field::kAnimation) && !request.given(field::kTo))
    request.set(field::kTo, scene.motion_seconds);
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

std::string camera_name(const JobRequest& request, int frame) {
  const std::optional<Cameras> cameras = request.given(field::kCameras);
  if (!cameras) return "";
  const auto index = static_cast<size_t>(request.given(field::kAnimation) ? 0 : frame);
  return index < cameras->size() ? (*cameras)[index].name : "";
}

Result<std::vector<JobFrame>> frames_of(const JobRequest& asked, const Scene& scene) {
  JobRequest request = asked;
  complete_frames(request, scene);
  if (request.given(field::kAnimation)) return animation_of(request, scene);
  const Camera camera = camera_of_request(request, scene.camera);
  if (request.given(field::kTurntable)) return turntable_of(request, camera);
  const std::optional<Cameras> cameras = request.given(field::kCameras);
  if (!cameras) return std::vector<JobFrame>{{"", camera, {}}};
  std::vector<JobFrame> frames;
  for (size_t i = 0; i < cameras->size(); ++i) {
    const CameraChoice& choice = (*cameras)[i];
    const NamedCamera* own = choice.name.empty() ? nullptr : scene.find_camera(choice.name);
    if (!choice.name.empty() && !own) return no_such_camera(i, choice.name, scene);
    frames.push_back({choice.name, own ? own->camera : camera_of(choice.camera, camera), {}});
    const std::string place = "/frames/cameras/" + std::to_string(i);
    if (const Status good = validate_camera(frames.back().camera, place); !good.ok())
      return good.error();
  }
  if (frames.empty() || frames.size() > size_t{kMaxFrames})
    return wrong_field("cameras", "expected 1.." + std::to_string(kMaxFrames) + " cameras, got " +
                                      std::to_string(frames.size()));
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
                              const std::vector<JobFrame>& frames, int frame) {
  settings.camera = frames[static_cast<size_t>(frame)].camera;
  if (frame > 0 && request.get(field::kSeeds) != "one")
    settings.seed = mix64(settings.seed + static_cast<uint64_t>(frame));
  return settings;
}

}  // namespace qray
