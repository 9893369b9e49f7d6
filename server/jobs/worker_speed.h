// How many samples this process has taken, and how fast it is: of what its running jobs say every
// now and then. One thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>

#include "server/model/job.h"

namespace qray::server {

class WorkerSpeed {
 public:
  // All that run now, with the samples that each has so far; and what was sampled for jobs of other
  // processes, in all.
  void look(std::map<JobId, uint64_t> now, uint64_t for_others, double seconds) {
    uint64_t added = for_others - for_others_;
    for_others_ = for_others;
    for (const auto& [id, samples] : now) {
      const auto before = last_.find(id);
      // What a job had when it was first seen may be another run's.
      if (before != last_.end() && samples > before->second) added += samples - before->second;
    }
    last_ = std::move(now);
    samples_ += added;
    const double time = seconds - at_;
    if (time < kShortest) {
      pending_ += added;
      return;
    }
    a_second_ = static_cast<double>(added + pending_) / time;
    pending_ = 0;
    at_ = seconds;
  }
  uint64_t samples() const { return samples_; }
  double a_second() const { return a_second_; }  // of the last moments

 private:
  static constexpr double kShortest = 1;
  std::map<JobId, uint64_t> last_;
  uint64_t samples_ = 0, pending_ = 0, for_others_ = 0;
  double at_ = 0, a_second_ = 0;
};

}  // namespace qray::server
