#include "core/import/json_scene.h"

namespace qray {
namespace {

constexpr float kRadians = kPi / 180;

void read_spot(const JsonNode& node, PunctualLight& light) {
  light.direction = normalize(node.get("direction").direction());
  light.outer_rad = node.get("outer_deg").number(0.1f, 180) * kRadians;
  if (const auto v = node.find("inner_deg")) light.inner_rad = v->number(0, 180) * kRadians;
  if (const auto v = node.find("falloff")) {
    if (v->string() == "linear_angle")
      light.falloff = SpotFalloff::kLinearAngle;
    else if (v->string() != "cosine_squared")
      v->fail_expected("one of cosine_squared, linear_angle");
  }
}

}  // namespace

std::string read_light_group(const JsonNode& node) {
  const auto group = node.find("light_group");
  if (!group) return {};
  constexpr size_t kMost = 64;
  if (group->string().empty() || group->string().size() > kMost)
    group->fail_expected("a name of 1..64 bytes");
  return group->string();
}

PunctualLight read_light(const JsonNode& node) {
  PunctualLight light;
  const JsonNode type = node.get("type");
  light.light_group = read_light_group(node);
  if (type.string() == "directional") {
    node.only({"type", "direction", "irradiance", "light_group", "motion"});
    light.kind = LightKind::kDirectional;
    light.direction = normalize(node.get("direction").direction());
    light.intensity = node.get("irradiance").number_or_rgb();
    return light;
  }
  if (type.string() == "spot") {
    node.only({"type", "position", "intensity", "direction", "inner_deg", "outer_deg", "falloff",
               "light_group", "motion"});
    light.kind = LightKind::kSpot;
    read_spot(node, light);
  } else if (type.string() == "point") {
    node.only({"type", "position", "intensity", "light_group", "motion"});
  } else {
    type.fail_expected("one of point, spot, directional");
  }
  light.position = node.get("position").vec3();
  light.intensity = node.get("intensity").number_or_rgb();
  return light;
}

}  // namespace qray
