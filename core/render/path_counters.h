// What a PathTracer counts. Sums of sums: in any order.
#pragma once

#include <cstdint>

namespace qray {

struct PathCounters {
  uint64_t paths = 0, rays = 0, dropped_samples = 0;
  uint64_t guided_paths = 0, guided_rays = 0;  // of those, that asked the guide for directions
  uint64_t lookups = 0;                        // surfaces where the guide was asked
  // Cycles of the timed steps (one in 64): in all, in ray queries, in the guide.
  uint64_t timed_total = 0, timed_tracing = 0, timed_guiding = 0;

  PathCounters& operator+=(const PathCounters& o);
  PathCounters& operator-=(const PathCounters& o);
  template <class Self, class Archive>
  static void exchange(Self& self, Archive& archive) {
    archive(self.paths, self.rays, self.dropped_samples, self.guided_paths, self.guided_rays,
            self.lookups, self.timed_total, self.timed_tracing, self.timed_guiding);
  }
};

}  // namespace qray
