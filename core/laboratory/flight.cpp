#include "core/laboratory/flight.h"

#include <algorithm>

#include "core/base/file.h"
#include "core/import/json_tree.h"
#include "core/scene/validate.h"

namespace qray {
namespace {

constexpr uint64_t kMaxFlightBytes = 8 << 20;
constexpr int kMaxKeys = 10'000;
constexpr float kMaxSeconds = 24 * 3600, kMaxFactor = 1e3f;

FlightKey read_key(const JsonNode& node, const Camera& camera) {
  node.only({"seconds", "position", "target", "up", "vertical_fov_deg", "cut", "lights"});
  FlightKey key;
  key.camera = camera;
  key.seconds = static_cast<double>(node.get("seconds").number(0, kMaxSeconds));
  if (const auto v = node.find("position")) key.camera.position = v->vec3();
  if (const auto v = node.find("target")) key.camera.target = v->vec3();
  if (const auto v = node.find("up")) key.camera.up = v->vec3();
  if (const auto v = node.find("vertical_fov_deg")) key.camera.vertical_fov_deg = v->number();
  if (const auto v = node.find("cut")) key.cut = v->boolean();
  if (const auto v = node.find("lights"))
    for (size_t i = 0; i < v->size(); ++i) key.lights.push_back(v->at(i).number(0, kMaxFactor));
  if (Status s = validate_camera(key.camera); !s.ok()) node.fail(s.error().message);
  return key;
}

Vec3 catmull_rom(Vec3 a, Vec3 b, Vec3 c, Vec3 d, float t) {
  return b + (c - a) * (0.5f * t) + (a * 2 - b * 5 + c * 4 - d) * (0.5f * t * t) +
         (b * 3 - a - c * 3 + d) * (0.5f * t * t * t);
}

}  // namespace

Camera Flight::at(double seconds) const {
  const auto after = std::find_if(keys.begin(), keys.end(),
                                  [&](const FlightKey& k) { return k.seconds > seconds; });
  if (after == keys.begin()) return keys.front().camera;
  const auto before = after - 1;
  if (after == keys.end() || after->cut) return before->camera;
  const auto earlier = before == keys.begin() || before->cut ? before : before - 1;
  const auto later = after + 1 == keys.end() || (after + 1)->cut ? after : after + 1;
  const float t =
      static_cast<float>((seconds - before->seconds) / (after->seconds - before->seconds));
  const auto curve = [&](Vec3 Camera::*member) {
    return catmull_rom(earlier->camera.*member, before->camera.*member, after->camera.*member,
                       later->camera.*member, t);
  };
  Camera camera = before->camera;
  camera.position = curve(&Camera::position);
  camera.target = curve(&Camera::target);
  camera.up = curve(&Camera::up);
  camera.vertical_fov_deg =
      lerp(t, before->camera.vertical_fov_deg, after->camera.vertical_fov_deg);
  return camera;
}

std::vector<float> Flight::lights_at(double seconds) const {
  std::vector<float> lights;
  for (const FlightKey& key : keys)
    if (key.seconds <= seconds && !key.lights.empty()) lights = key.lights;
  return lights;
}

std::vector<double> Flight::events() const {
  std::vector<double> times;
  for (const FlightKey& key : keys)
    if (key.seconds > 0 && (key.cut || !key.lights.empty())) times.push_back(key.seconds);
  return times;
}

Result<Flight> load_flight(const std::filesystem::path& path, const Camera& camera) {
  const Result<Bytes> text = read_file(path, kMaxFlightBytes);
  if (!text.ok()) return text.error();
  try {
    const JsonValue document = parse_json(text.value(), path.string());
    const JsonNode root(document, path.string() + ":");
    root.only({"keys"});
    const JsonNode list = root.get("keys");
    if (list.size() == 0 || list.size() > kMaxKeys) list.fail_expected("1 to 10000 keys");
    Flight flight;
    for (size_t i = 0; i < list.size(); ++i) {
      flight.keys.push_back(read_key(list.at(i), camera));
      const double least = i == 0 ? 0 : flight.keys[i - 1].seconds;
      if (i == 0 ? flight.keys[i].seconds != 0 : !(flight.keys[i].seconds > least))
        list.at(i).get("seconds").fail(i == 0 ? "expected 0" : "expected more than the key before");
    }
    return flight;
  } catch (const ImportFailure& failure) {
    return failure.error;
  }
}

}  // namespace qray
