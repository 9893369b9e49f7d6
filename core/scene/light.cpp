#include "core/scene/light.h"

namespace qray {

constexpr float kHardEdge = 1e-7f;  // of angles, or their cosines, that are the same

Rgb PunctualLight::intensity_toward(Vec3 wi) const {
  if (kind == LightKind::kPoint) return intensity;
  const float cos_angle = std::clamp(dot(direction, wi), -1.0f, 1.0f);
  float share;
  if (falloff == SpotFalloff::kLinearAngle) {
    share = (outer_rad - std::acos(cos_angle)) / std::max(outer_rad - inner_rad, kHardEdge);
  } else {
    const float cos_outer = std::cos(outer_rad);
    share = (cos_angle - cos_outer) / std::max(std::cos(inner_rad) - cos_outer, kHardEdge);
  }
  share = std::clamp(share, 0.0f, 1.0f);
  return intensity * (falloff == SpotFalloff::kCosineSquared ? share * share : share);
}

Rgb PunctualLight::power() const {
  if (kind == LightKind::kPoint) return intensity * (4 * kPi);
  // The integral of the falloff over the cosine, from the outer angle's to 1.
  const float cos_inner = std::cos(inner_rad), cos_outer = std::cos(outer_rad);
  float share = 1 - cos_inner + (cos_inner - cos_outer) / 3;
  if (falloff == SpotFalloff::kLinearAngle) {
    const float edge = outer_rad - inner_rad;
    share = 1 - (edge > 1e-3f ? (std::sin(outer_rad) - std::sin(inner_rad)) / edge : cos_outer);
  }
  return intensity * (2 * kPi * share);
}

}  // namespace qray
