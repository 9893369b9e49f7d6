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

// Adds the cycles of a scope to `total` when `on`.
class CycleScope {
 public:
  CycleScope(bool on, uint64_t& total) : total_(on ? &total : nullptr) {
    if (total_) start_ = cycle_count();
  }
  ~CycleScope() {
    if (total_) *total_ += cycle_count() - start_;
  }
  CycleScope(const CycleScope&) = delete;
  CycleScope& operator=(const CycleScope&) = delete;

 private:
  uint64_t* total_;
  uint64_t start_ = 0;
};

}  // namespace qray
