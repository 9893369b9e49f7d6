// Whether a job's guide pays: the variance of its passes times what they cost, against the same
// without it (design, section 4). The first passes are unguided, to tell what that costs, unless a
// pilot (pilot.h) told it, or the table knows it and paid in the job that measured it. A picture
// with much noise tries its guide on all pixels. There is little to gain where the pilot had little
// noise, or where the table lost before: then the guide is tried late, on one pixel in kPart, where
// a trial costs next to nothing, until the table has seen enough. A guide that loses is left for
// the rest of the job; the table stops growing when the picture gains little by it, and learning
// ends when it gains nothing any more. Everything is counted, nothing timed, so that a job decides
// the same whatever machine it runs on.
#pragma once

#include <cstdint>
#include <vector>

#include "core/guide/guide_table.h"
#include "core/render/guided_pixels.h"

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
  static constexpr uint64_t kPart = GuidedPixels::kPart;
  static constexpr int kMostPilotSamples = 16;  // a pixel
  // Samples before a guide is tried that has little to gain: a picture with little noise or a table
  // that lost before; both of them.
  static constexpr uint64_t kLateStart = 8, kLatestStart = 32;
  // `lookup_rays`: the cost of asking the guide, in rays of this scene. `warm`: the guide starts
  // from a table. `open`: it rules from the start, whatever it gains. `worth`: of the table, to the
  // job that measured it last.
  explicit GuideGate(double lookup_rays, bool warm = false, bool open = false,
                     const GuideWorth& worth = {});
  // Whether a table of that worth guides from the first sample on.
  static bool paid(const GuideWorth& worth);

  // Of a pass that starts after `samples` a pixel, with a table that has seen so many events.
  bool guides(uint64_t samples, uint64_t table_samples_seen) const {
    return open_ || (awake(samples) && (trusted_ || samples >= kUnguidedSamples) &&
                     knows_enough(table_samples_seen));
  }
  // A table that saw fewer events makes fireflies.
  static bool knows_enough(uint64_t table_samples_seen) { return table_samples_seen >= kLeastSeen; }
  // Only one pixel in kPart asks the guide, and is learned from.
  bool on_part() const { return part_; }
  bool learns(uint64_t samples) const { return awake(samples) && learns_; }
  // It is not left, and its time has come.
  bool awake(uint64_t samples) const { return on_ && samples >= start_; }
  bool grows() const { return grows_; }
  bool on() const { return on_; }
  // Of a path, over the cost of a guided one in the pass that was judged last; before, as the table
  // tells it. 0: not known.
  double unguided_cost() const { return unguided_cost_; }

  // Of a pilot's gate: whether the pilot has told what it can, `samples` a pixel being done, with a
  // table that has seen so many events; and the gate that its job begins with.
  bool pilot_is_over(uint64_t samples, uint64_t table_samples_seen) const;
  static bool knows_noise(uint64_t samples) { return samples >= kUnguidedSamples; }
  GuideGate after_pilot() const;

  // What paths without a guide cost. `variance`: of a sample, as NoiseEstimate tells it, if most
  // pixels of the pass were unguided; else, or where it is not known, 0.
  void unguided(const PassCost& cost, double variance);
  // After a pass with guided pixels, `samples` a pixel being done, by which the table has seen so
  // many events. `cost`: of the guided pixels; of them are the variances of a sample too, as
  // NoiseEstimate tells them: their own, and what it would have been without the guide. Returns the
  // efficiency gain: variance x cost without the guide over the same with it; 0: not known.
  double guided(uint64_t samples, uint64_t table_samples_seen, const PassCost& cost,
                double variance, double unguided_variance);
  template <class Self, class Archive>
  static void exchange(Self& self, Archive& archive) {
    archive(self.warm_, self.trusted_, self.lost_, self.variance_, self.start_, self.part_,
            self.unguided_, self.unguided_cost_, self.checks_, self.brought_little_, self.on_,
            self.grows_, self.learns_);
  }

 private:
  static constexpr uint64_t kUnguidedSamples = 2;
  static constexpr uint64_t kLeastSeen = 200'000;
  struct Check {
    uint64_t samples = 0;
    double efficiency_gain = 0;
    template <class Self, class Archive>
    static void exchange(Self& self, Archive& archive) {
      archive(self.samples, self.efficiency_gain);
    }
  };

  bool noisy() const;
  // What learning as much again brought.
  void judge_learning(uint64_t samples, uint64_t table_samples_seen, double efficiency_gain);

  double lookup_rays_;
  bool warm_, open_;
  bool trusted_ = false;  // it guides from the first sample on: what paths cost without is known
  // Of a sample of the unguided passes, the greatest that one told: where rare light was missed,
  // one tells too little. 0: not known.
  double variance_ = 0;
  bool lost_ = false;   // the table did, in the job that measured it last
  uint64_t start_ = 0;  // samples before it is tried
  bool part_ = false;
  PassCost unguided_;  // of all passes without the guide
  double unguided_cost_ = 0;
  std::vector<Check> checks_;
  bool brought_little_ = false;  // learning, at the last check
  bool on_ = true, grows_ = true, learns_ = true;
};

}  // namespace qray
