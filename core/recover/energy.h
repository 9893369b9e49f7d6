// The light of a part of a picture: what samples have of it, what a guess has, and what the guess
// is to have. Values.
#pragma once

#include <algorithm>
#include <array>

#include "core/math/vec.h"

namespace qray {

using Sum3 = std::array<double, 3>;

struct Energy {
  Sum3 samples{}, guess{};
  double square = 0;  // of the luminances' distances: what the samples' noise is at most
  Rgb factor{1};

  void add(Rgb s, Rgb g) {
    for (int c = 0; c < 3; ++c) {
      samples[static_cast<size_t>(c)] += static_cast<double>(s[c]);
      guess[static_cast<size_t>(c)] += static_cast<double>(g[c]);
    }
    square += sqr(static_cast<double>(luminance(s) - luminance(g)));
  }
  // `count` pixels of each, [pixel][3].
  void add_row(const float* s, const float* g, int count) {
    for (int i = 0; i < 3 * count; i += 3)
      add({s[i], s[i + 1], s[i + 2]}, {g[i], g[i + 1], g[i + 2]});
  }
  void operator+=(const Energy& e) {
    for (size_t c = 0; c < 3; ++c) samples[c] += e.samples[c], guess[c] += e.guess[c];
    square += e.square;
  }

  // What it is to have, where it would have `given`: what is missing moves by 1 - variance /
  // missing, of squares (James and Stein, "Estimation with Quadratic Loss", 1961). `variance`: of
  // the samples' sum.
  Sum3 wanted(const Sum3& given, double variance) const {
    const double missing = luminance_of(samples) - luminance_of(given);
    const double share = missing * missing > variance ? 1 - variance / (missing * missing) : 0.0;
    Sum3 energy;
    for (size_t c = 0; c < 3; ++c) energy[c] = given[c] + share * (samples[c] - given[c]);
    return energy;
  }
  // The factor for that; `otherwise` where there is nothing to multiply.
  void set_factor(const Sum3& energy, const Rgb& otherwise) {
    constexpr float kMostFactor = 1e3f;  // guesses that are nearly black stay finite
    for (int c = 0; c < 3; ++c) {
      const size_t k = static_cast<size_t>(c);
      const double f = guess[k] > 0 ? energy[k] / guess[k] : static_cast<double>(otherwise[c]);
      factor[c] = std::min(static_cast<float>(f), kMostFactor);
    }
  }
  bool is_as_it_should_be() const {
    constexpr float kTouch = 1e-4f;  // relative: less is rounding
    return std::abs(factor.r - 1) <= kTouch && std::abs(factor.g - 1) <= kTouch &&
           std::abs(factor.b - 1) <= kTouch;
  }

  static double luminance_of(const Sum3& v) {
    return static_cast<double>(luminance(
        Rgb{static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])}));
  }
};

}  // namespace qray
