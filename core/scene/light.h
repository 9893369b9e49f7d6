// Lights without an extent: next event estimation alone finds them. Plain data.
#pragma once

#include <cstdint>
#include <string>

#include "core/math/vec.h"

namespace qray {

enum class LightKind : uint8_t { kPoint, kSpot, kDirectional };

// How a spot dims between its two angles. With a the angle from the axis:
enum class SpotFalloff : uint8_t {
  kCosineSquared,  // ((cos a - cos outer) / (cos inner - cos outer))^2: KHR_lights_punctual
  kLinearAngle,    // (outer - a) / (outer - inner): Mitsuba
};

struct PunctualLight {
  LightKind kind = LightKind::kPoint;
  // Point, spot: radiant intensity, W/sr per channel (of a spot: within the inner angle).
  // Directional: irradiance of a surface that faces it, W/m^2.
  Rgb intensity{1.0f};
  Vec3 position;              // point, spot
  Vec3 direction{0, 0, -1};   // unit, the way the light goes; spot: its axis; directional
  float inner_rad = 0;        // spot: full intensity up to here, from the axis
  float outer_rad = kPi / 4;  // spot: none from here on; inner_rad or more, at most pi
  SpotFalloff falloff = SpotFalloff::kCosineSquared;
  std::string light_group;  // empty: none

  bool emits() const { return max_component(intensity) > 0; }
  // What leaves toward `wi`, unit. pre: not directional.
  Rgb intensity_toward(Vec3 wi) const;
  Rgb power() const;  // W per channel; the same
};

}  // namespace qray
