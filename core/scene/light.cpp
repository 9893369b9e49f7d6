#include "core/scene/light.h"

namespace qray {

Rgb PunctualLight::intensity_toward(Vec3 wi) const {
  if (kind == LightKind::kPoint) return intensity;
  const float cos_angle = std::clamp(dot(direction, wi), -1.0f, 1.0f);
  float share;
  if (falloff == SpotFalloff::kLinearAngle) {
    share = (outer_rad - std::acos(cos_angle)) / (outer_rad - inner_rad);
  } else {
    const float cos_inner = std::cos(inner_rad), cos_outer = std::cos(outer_rad);
    share = (cos_angle - cos_outer) / (cos_inner - cos_outer);
  }
  share = std::clamp(share, 0.0f, 1.0f);
  return intensity * (falloff == SpotFalloff::kCosineSquared ? share * share : share);
}

}  // namespace qray
