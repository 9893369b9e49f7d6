// A ray and an axis-aligned box. Metres; `d` is a unit direction.
#pragma once

#include <limits>

#include "core/math/vec.h"

namespace qray {

struct Ray {
  Vec3 o, d;
  float t_max = std::numeric_limits<float>::infinity();
};

struct Bounds3 {
  Vec3 lo{std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity(),
          std::numeric_limits<float>::infinity()};
  Vec3 hi{-std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(),
          -std::numeric_limits<float>::infinity()};

  void add(Vec3 p) {
    lo = min(lo, p);
    hi = max(hi, p);
  }
  bool empty() const { return !(lo.x <= hi.x); }
  Vec3 center() const { return (lo + hi) * 0.5f; }
  Vec3 extent() const { return hi - lo; }
  float radius() const { return 0.5f * length(extent()); }
};

}  // namespace qray
