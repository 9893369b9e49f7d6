// Records the rays that the path tracer sends to Embree, by standing between the two at link time
// (--wrap), and traces them again with nothing around. Recording: from one thread; replay: any.
#pragma once

#include <cstddef>
#include <vector>

#include "core/math/vec.h"

namespace qray::bench {

struct RecordedRay {
  Vec3 o, d;
  float t_max;  // negative: a nearest-hit query; else an occlusion query of this length
};

// While it lives, rays are appended to `rays` and traced as usual.
class RayRecorder {
 public:
  explicit RayRecorder(std::vector<RecordedRay>& rays);
  ~RayRecorder();
  RayRecorder(const RayRecorder&) = delete;
  RayRecorder& operator=(const RayRecorder&) = delete;
};

// Traces rays [begin, end) in the scene that was recorded; returns how many hit something.
size_t replay(const std::vector<RecordedRay>& rays, size_t begin, size_t end);

}  // namespace qray::bench
