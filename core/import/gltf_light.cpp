#include "core/import/gltf_light.h"

#include <algorithm>
#include <cmath>

#include "core/scene/motion.h"
#include "core/scene/value_ranges.h"

namespace qray {
namespace {

Vec3 unit_column(const Transform& t, size_t c, const JsonNode& place) {
  const Vec3 v = t.column(c);
  const float norm = length(v);
  if (!(norm > 0 && std::isfinite(norm))) place.fail("is flattened by the nodes above it");
  return v / norm;
}

Vec3 position_of(const Transform& t, const JsonNode& place) {
  const Vec3 p = t.column(3);
  for (int axis = 0; axis < 3; ++axis)
    if (!(std::abs(p[axis]) <= kMaxCoordinate)) place.fail("expected a place within 1e6 m");
  return p;
}

}  // namespace

// Candela are taken as W/sr and lux as W/m^2, in every channel.
PunctualLight read_gltf_light(const JsonNode& index_node, const Transform& to_world,
                              GltfImport& import) {
  const auto all = find_extension(import.document.root(), "KHR_lights_punctual");
  const auto lights = all ? all->find("lights") : std::nullopt;
  if (!lights || lights->size() == 0) index_node.fail("expected no index, there are no lights");
  const JsonNode node =
      lights->at(static_cast<size_t>(index_node.integer(0, static_cast<int>(lights->size()) - 1)));
  PunctualLight light;
  float strength = 1;
  if (const auto v = node.find("intensity")) strength = v->number(0, kMaxRadiance);
  light.intensity = Rgb{strength};
  if (const auto color = node.find("color")) {
    const std::vector<float> rgb = color->numbers(3);
    for (int i = 0; i < 3; ++i) {
      if (rgb[static_cast<size_t>(i)] < 0) color->fail_expected("numbers from 0");
      light.intensity[i] = std::min(strength * rgb[static_cast<size_t>(i)], kMaxRadiance);
    }
  }
  light.position = position_of(to_world, index_node);
  const JsonNode type = node.get("type");
  if (type.string() == "point") return light;
  light.direction = -unit_column(to_world, 2, index_node);
  if (type.string() == "directional") {
    light.kind = LightKind::kDirectional;
    return light;
  }
  if (type.string() != "spot") type.fail_expected("point, spot or directional");
  light.kind = LightKind::kSpot;
  const JsonNode spot = node.get("spot");
  if (const auto v = spot.find("outerConeAngle")) light.outer_rad = v->number(1e-6f, kPi / 2);
  if (const auto v = spot.find("innerConeAngle")) light.inner_rad = v->number(0, light.outer_rad);
  return light;
}

void read_gltf_camera(const JsonNode& camera, const JsonNode& node, const Transform& to_world,
                      GltfImport& import) {
  const JsonNode type = camera.get("type");
  Scene& scene = import.out.scene;
  Camera& out = scene.camera;
  std::optional<float> aspect;
  if (type.string() == "perspective") {
    const JsonNode perspective = camera.get("perspective");
    out.vertical_fov_deg = perspective.get("yfov").number(1e-4f, kPi * 0.999f) * (180 / kPi);
    if (const auto v = perspective.find("aspectRatio")) aspect = v->number(1e-2f, 1e2f);
  } else if (type.string() == "orthographic") {
    const JsonNode orthographic = camera.get("orthographic");
    // Half of what is seen; a negative one turns the picture, which is left as it is.
    const auto half = [&](const char* name) {
      const float magnitude = std::abs(orthographic.get(name).number());
      if (!(magnitude > 0 && magnitude <= kMaxCoordinate / 2))
        orthographic.get(name).fail_expected("a length over 0, at most 5e5 m");
      return magnitude;
    };
    out.projection = Projection::kOrthographic;
    out.height = 2 * half("ymag");
    aspect = std::clamp(2 * half("xmag") / out.height, 1e-2f, 1e2f);
  } else {
    type.fail_expected("perspective or orthographic");
  }
  if (aspect) {
    // As many pixels as the default, about.
    const double root = std::sqrt(static_cast<double>(*aspect));
    const int most = import.limits.max_dimension_px;
    scene.width = std::clamp(static_cast<int>(std::lround(512 * root)), 1, most);
    scene.height = std::clamp(static_cast<int>(std::lround(512 / root)), 1, most);
  }
  (void)position_of(to_world, node);
  for (const size_t column : {1, 2}) (void)unit_column(to_world, column, node);
  out = placed_camera(out, to_world);
}

}  // namespace qray
