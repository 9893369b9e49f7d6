// The size of each pass, and what fits the budget. Totals grow by about sqrt 2, so that a table is
// soon of use and a picture of any age is near: 1, 2, 3, 4, 6, 8, 12, 16 ... up to a cap. Where the
// budget is time and less is left than a sample of all pixels takes, a last pass begins that ends
// with the time, wherever it is by then. One thread.
#pragma once

#include <cstdint>
#include <vector>

#include "core/settings/render_settings.h"

namespace qray {

// How far a render is.
struct RenderAge {
  uint64_t samples = 0;  // a pixel, in complete passes
  double seconds = 0;
  double noise = 0;  // the picture's relative error; 0: not known
};

class PassPlan {
 public:
  static constexpr int kMostSamples = 64;  // a pixel, of a job's pass
  explicit PassPlan(const RenderSettings& settings, int most_samples = kMostSamples);

  // Whether the job is done: no pass is left.
  bool over(const RenderAge& age) const;
  // Begins the next pass; its samples a pixel, 0: the job is done.
  int start(const RenderAge& age, double last_pass_seconds);
  // Whether the guide learns from a pass that begins now.
  bool learning(const RenderAge& age) const;
  // Whether a pass that the guide does not learn from is over, whole or not, by the time.
  bool out_of_time(const RenderAge& age) const;
  // Of the job, [0, 1]. `in_pass`: samples a pixel of the pass under way.
  double fraction(const RenderAge& age, double in_pass) const;
  const std::vector<int>& passes() const { return passes_; }

  template <class Self, class Archive>
  static void exchange(Self& self, Archive& archive) {
    archive(self.passes_, self.hurries_);
  }

 private:
  const RenderSettings& settings_;
  const int most_samples_;  // a pixel, of a pass
  int64_t total_ = 0;       // samples a pixel; 0: no bound
  bool hurries_ = false;    // the time that was left did not seem to do for a whole pass
  std::vector<int> passes_;
};

}  // namespace qray
