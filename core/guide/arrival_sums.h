// What `adaptive` counts at a place: what arrives, and by which share of the guide lobes send on
// with the least noise. Sums in fixed point, so that neither the order nor the threads that add to
// them change a bit. Not synchronised.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "core/guide/direction_tree.h"
#include "core/guide/lobe_shares.h"
#include "core/math/vec.h"

namespace qray {

// Of n samples of y = radiance x cos / (pi pdf), in units of radiance that the table has.
struct ArrivalSums {
  static constexpr double kOne = 0x1p32;  // a unit
  static constexpr double kSquareOne = 0x1p30, kSquareRest = 0x1p30;

  int64_t n = 0, n_upper = 0;  // n_upper: those of n in the place's upper half
  int64_t y[3]{};              // red, green, blue
  // Of luminance squared: whole parts and what is left of them, since squares range widely.
  int64_t square_hi = 0, square_lo = 0;
  LobeShares lobes;

  static int64_t to_fixed(double v) { return static_cast<int64_t>(v); }

  // One sample. `factor`: y over radiance; `paid`: luminance of y.
  static ArrivalSums of(Rgb radiance, double factor, double paid, bool upper) {
    const double square = paid * paid * kSquareOne, whole = std::floor(square);
    ArrivalSums one;
    one.n = 1;
    one.n_upper = upper;
    for (int k = 0; k < 3; ++k) one.y[k] = to_fixed(radiance[k] * factor * kOne);
    one.square_hi = to_fixed(whole);
    one.square_lo = to_fixed((square - whole) * kSquareRest);
    return one;
  }
  ArrivalSums& operator+=(const ArrivalSums& o) { return add(o, 1); }
  ArrivalSums& operator-=(const ArrivalSums& o) { return add(o, -1); }
  Rgb mean() const {
    Rgb mean;
    for (int k = 0; k < 3; ++k)
      mean[k] = static_cast<float>(static_cast<double>(y[k]) / kOne / static_cast<double>(n));
    return mean;
  }
  double deviation() const {  // standard, of a sample's luminance
    const double square =
        (static_cast<double>(square_hi) + static_cast<double>(square_lo) / kSquareRest) /
        kSquareOne / static_cast<double>(n);
    return std::sqrt(std::max(0.0, square - sqr(luminance(mean()))));
  }
  // Rounded toward zero.
  void scale(int64_t numerator, int64_t denominator) {
    for (int64_t* v : all()) *v = DirectionTrees::scaled(*v, numerator, denominator);
  }

  // In the order of a table's file; the first kArrival of them do without `lobes`.
  static constexpr size_t kArrival = 7, kAll = kArrival + LobeShares::kShares.size();
  std::array<int64_t*, kAll> all() { return all_of<int64_t*>(*this); }
  std::array<const int64_t*, kAll> all() const { return all_of<const int64_t*>(*this); }

 private:
  template <class Pointer, class Self>
  static std::array<Pointer, kAll> all_of(Self& s) {
    return {&s.n,
            &s.n_upper,
            &s.y[0],
            &s.y[1],
            &s.y[2],
            &s.square_hi,
            &s.square_lo,
            &s.lobes.moments[0],
            &s.lobes.moments[1],
            &s.lobes.moments[2],
            &s.lobes.moments[3]};
  }
  ArrivalSums& add(const ArrivalSums& o, int64_t sign) {
    n += sign * o.n;
    n_upper += sign * o.n_upper;
    for (int k = 0; k < 3; ++k) y[k] += sign * o.y[k];
    square_hi += sign * o.square_hi;
    square_lo += sign * o.square_lo;
    for (size_t k = 0; k < LobeShares::kShares.size(); ++k)
      lobes.moments[k] += sign * o.lobes.moments[k];
    return *this;
  }
};

}  // namespace qray
