// What a guide is made for: the scene's size and lights, its memory, its method's parameters.
#pragma once

#include <cstddef>

#include "core/guide/adaptive_params.h"
#include "core/guide/huang_params.h"
#include "core/guide/light_clusters.h"
#include "core/math/ray.h"

namespace qray {

constexpr size_t kDefaultTableBytes = size_t{256} << 20;  // of memory, unless a job says otherwise

struct GuideSetup {
  Bounds3 bounds;             // of the scene, metres
  float brightest_light = 1;  // luminance
  size_t max_bytes = kDefaultTableBytes;
  HuangParams huang;
  AdaptiveParams adaptive;
  LightClusters lights = {};  // no groups: nothing is learned of them
};

}  // namespace qray
