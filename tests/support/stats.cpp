#include "tests/support/stats.h"

#include <limits>

namespace qray::test {
namespace {

// Regularised upper incomplete gamma Q(a, x) (DLMF 8.7.1 and the continued fraction 8.9.2).
double gamma_q(double a, double x) {
  if (x <= 0) return 1;
  const double scale = std::exp(-x + a * std::log(x) - std::lgamma(a));
  if (x < a + 1) {
    double term = 1 / a, sum = term;
    for (double n = a + 1; term > sum * 1e-16; ++n) sum += term *= x / n;
    return 1 - sum * scale;
  }
  // Lentz's evaluation of 1/(x+1-a- 1(1-a)/(x+3-a- ...)).
  constexpr double kTiny = 1e-300;
  double b = x + 1 - a, c = 1 / kTiny, d = 1 / b, fraction = d;
  for (int i = 1; i < 100'000; ++i) {
    const double an = -i * (i - a);
    b += 2;
    d = an * d + b;
    d = 1 / (std::abs(d) < kTiny ? kTiny : d);
    c = b + an / c;
    if (std::abs(c) < kTiny) c = kTiny;
    fraction *= d * c;
    if (std::abs(d * c - 1) < 1e-15) break;
  }
  return fraction * scale;
}

ZTest from(double difference, double error) {
  if (error > 0) return {difference / error, normal_tail(difference / error)};
  if (difference == 0) return {0, 1};
  return {std::copysign(std::numeric_limits<double>::infinity(), difference), 0};
}

}  // namespace

double chi2_tail(double statistic, double dof) { return gamma_q(dof / 2, statistic / 2); }

double normal_tail(double z) { return std::erfc(std::abs(z) / std::sqrt(2.0)); }

ZTest z_test(const Moments& sample, double expected, double floor) {
  return from(sample.mean() - expected, std::hypot(sample.standard_error(), floor));
}

ZTest z_test(const Moments& a, const Moments& b) {
  return from(a.mean() - b.mean(), std::hypot(a.standard_error(), b.standard_error()));
}

}  // namespace qray::test
