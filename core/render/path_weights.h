// Weights of light on a path's way.
#pragma once

#include <cmath>

#include "core/math/vec.h"

namespace qray {

// Beer and Lambert's law. `absorption`: per metre; `distance`: metres.
inline Rgb transmittance(Rgb absorption, float distance) {
  return {std::exp(-absorption.r * distance), std::exp(-absorption.g * distance),
          std::exp(-absorption.b * distance)};
}

inline float power_heuristic(float pdf, float other_pdf) {
  return 1 / (1 + sqr(other_pdf / pdf));  // of the ratio, so that squares cannot overflow
}

}  // namespace qray
