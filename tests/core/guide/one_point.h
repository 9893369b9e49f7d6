// A scene of which a guide learns at one point only.
#pragma once

#include "core/guide/guide.h"

namespace qray::test {

inline const Vec3 kPoint{0.4f, 0.3f, 0.6f}, kNormal{0, 0, 1};

inline GuideSetup unit_cube() {
  GuideSetup setup;
  setup.bounds = {{0, 0, 0}, {1, 1, 1}};
  return setup;
}

}  // namespace qray::test
