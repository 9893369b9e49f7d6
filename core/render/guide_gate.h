// Whether a job's guide pays: the variance of its passes times what they cost, against the same
// without it (design, section 4). The first passes are unguided: they tell what that costs. A guide
// that loses is left for the rest of the job; the table stops growing when the picture gains little
// by it, and learning ends when it gains nothing any more. Everything is counted, nothing timed, so
// that a job decides the same whatever machine it runs on.
#pragma once

#include <cstdint>
#include <vector>

namespace qray {

// What passes cost, in rays.
struct PassCost {
  double paths = 0, rays = 0, lookups = 0;  // lookups: surfaces where the guide was asked
  template <class Self, class Archive>
  static void exchange(Self& self, Archive& archive) {
    archive(self.paths, self.rays, self.lookups);
  }
  double per_path(double lookup_rays) const {
    return paths > 0 ? (rays + lookup_rays * lookups) / paths : 0;
  }
  PassCost operator-(const PassCost& o) const {
    return {paths - o.paths, rays - o.rays, lookups - o.lookups};
  }
};

class GuideGate {
 public:
  // `lookup_rays`: the cost of asking the guide, in rays of this scene.
  // `warm`: the guide starts from a table. `open`: it rules from the start, whatever it gains.
  explicit GuideGate(double lookup_rays, bool warm = false, bool open = false)
      : lookup_rays_(lookup_rays), warm_(warm), open_(open) {}

  // Of a pass that starts after `samples` a pixel, with a table that has seen so many events.
  bool guides(uint64_t samples, uint64_t table_samples_seen) const {
    return open_ || (on_ && samples >= kUnguidedSamples && knows_enough(table_samples_seen));
  }
  // Fewer events make noise.
  static bool knows_enough(uint64_t table_samples_seen) { return table_samples_seen >= kLeastSeen; }
  bool learns() const { return on_ && learns_; }
  bool grows() const { return grows_; }
  bool on() const { return on_; }

  void unguided_pass(const PassCost& cost);
  // After a guided pass, `samples` a pixel being done. Variances of a sample, as NoiseEstimate
  // tells them: the pass' own, and what it would have been without the guide. Returns the
  // efficiency gain: variance x cost without the guide over the same with it; 0: not known.
  double guided_pass(uint64_t samples, const PassCost& cost, double variance,
                     double unguided_variance);
  template <class Self, class Archive>
  static void exchange(Self& self, Archive& archive) {
    archive(self.warm_, self.unguided_, self.checks_, self.brought_little_, self.on_, self.grows_,
            self.learns_);
  }

 private:
  static constexpr uint64_t kUnguidedSamples = 2;
  static constexpr uint64_t kLeastSeen = 50'000;
  struct Check {
    uint64_t samples = 0;
    double efficiency_gain = 0;
    template <class Self, class Archive>
    static void exchange(Self& self, Archive& archive) {
      archive(self.samples, self.efficiency_gain);
    }
  };

  double lookup_rays_;
  bool warm_, open_;
  PassCost unguided_;
  std::vector<Check> checks_;
  bool brought_little_ = false;  // learning, at the last check
  bool on_ = true, grows_ = true, learns_ = true;
};

}  // namespace qray
