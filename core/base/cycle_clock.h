// A cheap count of time for sampled profiling: the time stamp counter where there is one. Only
// ratios of differences mean anything.
#pragma once

#include <chrono>
#include <cstdint>

namespace qray {

inline uint64_t cycle_count() {
#if defined(__x86_64__)
  return __builtin_ia32_rdtsc();
#else
  return static_cast<uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
#endif
}

}  // namespace qray
