// Statistics that tests decide by. Seeds are fixed, so a test's verdict never changes by itself;
// the significance still guards against a seed chosen until it passes. Any thread.
#pragma once

#include <cmath>
#include <cstdint>

namespace qray::test {

// Chance that a family of tests of correct code fails, before its seeds are fixed.
constexpr double kFalseAlarm = 1e-3;
// The level for each of `tests` tests (Bonferroni).
constexpr double significance(int tests) { return kFalseAlarm / tests; }

// P(chi-square with `dof` degrees of freedom > statistic).
double chi2_tail(double statistic, double dof);
// P(|standard normal| > |z|).
double normal_tail(double z);

// Running mean and variance (Welford).
class Moments {
 public:
  void add(double x) {
    const double delta = x - mean_;
    mean_ += delta / static_cast<double>(++count_);
    squares_ += delta * (x - mean_);
  }
  uint64_t count() const { return count_; }
  double mean() const { return mean_; }
  double variance() const { return count_ > 1 ? squares_ / static_cast<double>(count_ - 1) : 0.0; }
  double standard_error() const { return std::sqrt(variance() / static_cast<double>(count_)); }

 private:
  uint64_t count_ = 0;
  double mean_ = 0, squares_ = 0;
};

struct ZTest {
  double z;
  double p_value;  // two-sided
};
// Is the mean `expected`? `floor` is an error to be forgiven beside the standard error (rounding).
ZTest z_test(const Moments& sample, double expected, double floor = 0);
// Have both the same mean?
ZTest z_test(const Moments& a, const Moments& b);

}  // namespace qray::test
