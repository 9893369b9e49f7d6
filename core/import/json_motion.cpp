#include "core/import/json_motion.h"

namespace qray {
namespace {

constexpr size_t kMaxKeys = 10'000;
constexpr float kMaxSeconds = 1e6f, kMaxDegrees = 1e6f, kMinScale = 1e-6f;

// One value for each key, each read by `add`.
template <class Add>
Track read_track(const JsonNode& values, const std::vector<float>& seconds, size_t width, Add add) {
  if (!values.is_array() || values.size() != seconds.size())
    values.fail_expected(std::to_string(seconds.size()) + " values, one for each of \"seconds\"");
  Track track;
  track.seconds = seconds;
  track.width = width;
  for (size_t i = 0; i < seconds.size(); ++i) add(values.at(i), track.values);
  return track;
}

std::vector<float> read_seconds(const JsonNode& node) {
  if (!node.is_array() || node.size() == 0 || node.size() > kMaxKeys)
    node.fail_expected("1.." + std::to_string(kMaxKeys) + " times, in seconds");
  std::vector<float> seconds;
  for (size_t i = 0; i < node.size(); ++i) {
    seconds.push_back(node.at(i).number(0, kMaxSeconds));
    if (i > 0 && !(seconds[i] > seconds[i - 1]))
      node.at(i).fail_expected("a time after the one before it");
  }
  return seconds;
}

std::vector<double> doubles_of(Vec3 v) { return {double{v.x}, double{v.y}, double{v.z}}; }

// As a node's map: it looks along -z, +y is up.
NodePose pose_of(const Camera& camera) {
  const Vec3 back = normalize(camera.position - camera.target);
  const Vec3 right = normalize(cross(camera.up, back));
  const Vec3 side = camera.mirrored ? -right : right;
  NodePose pose;
  for (const Vec3 column : {side, cross(back, right), back, camera.position}) {
    for (const double v : doubles_of(column)) pose.matrix.push_back(v);
    pose.matrix.push_back(pose.matrix.size() == 15 ? 1 : 0);
  }
  return pose;
}

}  // namespace

std::optional<JsonMotion> JsonMotion::read(const JsonNode& node) {
  const auto found = node.find("motion");
  if (!found) return std::nullopt;
  found->only({"seconds", "translate", "rotate", "scale", "center"});
  JsonMotion out;
  const std::vector<float> seconds = read_seconds(found->get("seconds"));
  if (const auto center = found->find("center")) out.center_ = center->vec3();
  if (const auto translate = found->find("translate"))
    out.motion_.translation =
        read_track(*translate, seconds, 3, [](const JsonNode& value, std::vector<float>& to) {
          const Vec3 v = value.vec3();
          to.insert(to.end(), {v.x, v.y, v.z});
        });
  if (const auto rotate = found->find("rotate")) {
    rotate->only({"axis", "deg"});
    out.motion_.axis = rotate->get("axis").direction();
    out.motion_.rotation = read_track(rotate->get("deg"), seconds, 1,
                                      [](const JsonNode& value, std::vector<float>& to) {
                                        to.push_back(value.number(-kMaxDegrees, kMaxDegrees));
                                      });
  }
  if (const auto scale = found->find("scale"))
    out.motion_.scale =
        read_track(*scale, seconds, 3, [](const JsonNode& value, std::vector<float>& to) {
          to.insert(to.end(), 3, value.number(kMinScale, kMaxCoordinate));
        });
  if (!out.motion_.moves_node()) found->fail("expected \"translate\", \"rotate\" or \"scale\"");
  return out;
}

Transform JsonMotion::at(double seconds) const {
  return Transform::translation(center_)
      .after(motion_.at(seconds, {}).to_parent())
      .after(Transform::translation(-center_));
}

std::shared_ptr<const CameraPath> JsonMotion::path_of(const Camera& rest) const {
  auto path = std::make_shared<CameraPath>();
  path->lens = rest;
  if (rest.aperture_radius > 0 && rest.focus_distance == 0)
    path->lens.focus_distance = length(rest.target - rest.position);
  NodePose to_center, from_center;
  to_center.translation = doubles_of(center_);
  from_center.translation = doubles_of(-center_);
  path->steps = {
      {to_center}, {{}, std::make_shared<NodeMotion>(motion_)}, {from_center}, {pose_of(rest)}};
  return path;
}

void place_light(const Transform& to_world, PunctualLight& light) {
  light.position = to_world.point(light.position);
  light.direction = normalize(to_world.point(light.direction) - to_world.point({}));
}

}  // namespace qray
