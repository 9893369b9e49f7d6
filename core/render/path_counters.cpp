#include "core/render/path_counters.h"

namespace qray {

PathCounters& PathCounters::operator+=(const PathCounters& o) {
  paths += o.paths;
  rays += o.rays;
  guided_paths += o.guided_paths;
  guided_rays += o.guided_rays;
  lookups += o.lookups;
  dropped_samples += o.dropped_samples;
  timed_total += o.timed_total;
  timed_tracing += o.timed_tracing;
  timed_guiding += o.timed_guiding;
  return *this;
}

PathCounters& PathCounters::operator-=(const PathCounters& o) {
  paths -= o.paths;
  rays -= o.rays;
  guided_paths -= o.guided_paths;
  guided_rays -= o.guided_rays;
  lookups -= o.lookups;
  dropped_samples -= o.dropped_samples;
  timed_total -= o.timed_total;
  timed_tracing -= o.timed_tracing;
  timed_guiding -= o.timed_guiding;
  return *this;
}

}  // namespace qray
