// How noisy the picture is, from how far two halves of a pixel's samples lie apart. Two kinds of
// halves tell two things. Samples of even and of odd number differ as independent ones do: their
// distance is a sample's own noise, which Russian roulette weighs against what a path may still
// bring, and by which the gate (guide_gate.h) compares a guided pass with what it would be
// unguided. The earlier and the later half of each pass are Sobol points of their own: their
// distance is near to the picture's error, of which stratification has taken its part; the stop by
// noise asks for that. Between passes one thread; add() from any, a pixel's from one at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/render/tile_samples.h"

namespace qray {

class NoiseEstimate {
 public:
  NoiseEstimate(int width, int height);

  // `learning`: the guide is told what its directions were paid, so that what it saves is known.
  void start_pass(bool guided, bool learning);
  // Sums of the luminance of a pixel's `count` samples from number `first` on, and of what guiding
  // saved of its second moment; none where the pass guides only some pixels, and not this one.
  void add(int x, int y, uint32_t first, uint32_t count, const SampleHalves<float>& sums,
           std::optional<double> saved);
  // False: no pixel has samples of both kinds yet, the next pass goes on.
  bool end_pass();

  // Standard deviation of the luminance of one sample, blurred; 0: not known.
  float deviation(int x, int y) const {
    return deviation_.empty() ? 0.0f : deviation_[index(x, y)];
  }
  std::span<const float> deviations() const { return deviation_; }  // of all; empty: not known
  float samples(int x, int y) const {
    return all_count_[0][index(x, y)] + all_count_[1][index(x, y)];
  }
  // Mean over pixels of a sample's variance over (mean^2 + (median / 2)^2), where the median is of
  // the means that are not black, without the greatest 0.1 %, of the last passes; 0: not known.
  // With the means known by now, blurred: a firefly must not hide behind itself.
  double variance() const { return variance_; }
  // Of the estimate before; by the same means.
  double variance_before() const { return variance_before_; }
  // The same of the guided pixels alone, and what it would have been there without a guide, by what
  // that saved.
  double guided_variance() const { return guided_variance_; }
  double unguided_variance() const { return unguided_variance_; }
  // What a film's samples from before the last estimate count against those to come, by their
  // noise, so that the sum has the least: Film::fade(). 1 where it is not known, and at most: where
  // earlier samples seem to have less noise, they have more likely missed rare light.
  float weight_of_earlier() const;

  // Of the pixel's mean so far: standard error over what it and its neighbours are like on average,
  // at most kMostError; that where it is not known.
  float relative_error(int x, int y) const;
  // Of 5 x 5 pixels about each: standard deviation of a sample over the root of (mean^2 + floor^2),
  // where the floor is `dark` times the picture's median, which black pixels do not count for. In a
  // black picture 0.
  std::vector<float> spread(float dark = 1) const;
  // Of the pixel's mean so far, by how far the earlier halves of its passes are from the later
  // ones: squared, of one degree of freedom, unbiased where samples are independent. A firefly
  // counts in full. Infinite: not known.
  float own_error(int x, int y) const;
  bool known() const { return !deviation_.empty(); }
  // Of the picture so far: root of the mean of own_error()^2 over (mean^2 + 0.01), the greatest
  // 0.1 % left out as above. 0: not known.
  double level() const;
  static constexpr float kMostError = 16;

  template <class Self, class Archive>
  static void exchange(Self& self, Archive& archive) {
    archive(self.guided_, self.all_[0], self.all_[1], self.all_count_[0], self.all_count_[1],
            self.half_[0], self.half_[1], self.count_[0], self.count_[1], self.mean_, self.square_,
            self.before_, self.learning_, self.saved_, self.guided_samples_, self.distance_,
            self.deviation_, self.variance_, self.variance_before_, self.guided_variance_,
            self.unguided_variance_);
  }

 private:
  size_t index(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x);
  }
  static double trimmed_mean(const std::vector<float>& squares, const std::vector<float>& means,
                             float floor);
  void blur(std::vector<float>& values, int radius) const;
  std::vector<float> means() const;  // of each pixel's luminance so far
  // Of everything that end_pass() begins anew.
  template <class F>
  void for_each_sum(const F& f) {
    for (auto* sums : {&half_[0], &half_[1], &count_[0], &count_[1], &saved_, &guided_samples_})
      f(*sums);
  }

  int width_, height_;
  bool guided_ = false, learning_ = false;
  // Of luminance: all samples, by earlier and later; since the last estimate, by even and odd.
  std::vector<float> all_[2], all_count_[2];
  std::vector<float> half_[2], count_[2];
  std::vector<float> mean_;    // of luminance, blurred
  std::vector<float> square_;  // a sample's variance by the last estimate
  std::vector<float> before_;  // square_ of the estimate before
  // Since the last estimate: sums of what guiding saved, and how many samples were guided.
  std::vector<float> saved_, guided_samples_;
  std::vector<float> distance_;  // roots of square_, faded over passes
  std::vector<float> deviation_;
  double variance_ = 0, variance_before_ = 0, guided_variance_ = 0, unguided_variance_ = 0;
};

}  // namespace qray
