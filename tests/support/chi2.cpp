#include "tests/support/chi2.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <vector>

#include "tests/support/stats.h"

namespace qray::test {
namespace {

constexpr double kMinExpected = 5;  // per cell, the usual rule for Pearson's statistic
constexpr double kRounding = 2;     // samples that may round into an empty neighbour cell
constexpr int kLookCloser = 5;      // halvings of a cell where a narrow peak may have been missed

using Density = std::function<double(double a, double b)>;

// 4 x 4 Gauss-Legendre points.
double gauss(const Density& f, double a0, double a1, double b0, double b1) {
  static constexpr std::array<double, 4> kX{-0.861136311594052575, -0.339981043584856265,
                                            0.339981043584856265, 0.861136311594052575};
  static constexpr std::array<double, 4> kW{0.347854845137453857, 0.652145154862546143,
                                            0.652145154862546143, 0.347854845137453857};
  const double ah = (a1 - a0) / 2, am = (a1 + a0) / 2, bh = (b1 - b0) / 2, bm = (b1 + b0) / 2;
  double sum = 0;
  for (size_t i = 0; i < 4; ++i)
    for (size_t j = 0; j < 4; ++j) sum += kW[i] * kW[j] * f(am + ah * kX[i], bm + bh * kX[j]);
  return sum * ah * bh;
}

// The first `certain` halvings are made whether they change anything or not.
double integrate(const Density& f, double a0, double a1, double b0, double b1, double coarse,
                 int depth, double tolerance, int certain = 0) {
  const double am = (a0 + a1) / 2, bm = (b0 + b1) / 2;
  const double q00 = gauss(f, a0, am, b0, bm), q01 = gauss(f, a0, am, bm, b1);
  const double q10 = gauss(f, am, a1, b0, bm), q11 = gauss(f, am, a1, bm, b1);
  const double fine = q00 + q01 + q10 + q11;
  if (depth == 0 || (certain <= 0 && std::abs(fine - coarse) < tolerance)) return fine;
  return integrate(f, a0, am, b0, bm, q00, depth - 1, tolerance / 2, certain - 1) +
         integrate(f, a0, am, bm, b1, q01, depth - 1, tolerance / 2, certain - 1) +
         integrate(f, am, a1, b0, bm, q10, depth - 1, tolerance / 2, certain - 1) +
         integrate(f, am, a1, bm, b1, q11, depth - 1, tolerance / 2, certain - 1);
}

// A domain [0, 1) x [0, 1) of equal cells; `scale` times the density's integral over it is a
// probability.
Chi2 run(const std::function<std::optional<Vec2>(Random&)>& sample, const Density& density,
         double scale, const Chi2Options& o) {
  const size_t nu = static_cast<size_t>(o.bins_u), nv = static_cast<size_t>(o.bins_v);
  std::vector<double> expected(nu * nv + 1), observed(nu * nv + 1, 0.0);
  Random random(o.seed);
  for (int s = 0; s < o.samples; ++s) {
    const std::optional<Vec2> at = sample(random);
    if (!at) {
      ++observed.back();
      continue;
    }
    const auto bin = [](float v, size_t n) {
      return std::min(n - 1, static_cast<size_t>(std::max(0.0f, v) * static_cast<float>(n)));
    };
    ++observed[bin(at->x, nu) * nv + bin(at->y, nv)];
  }

  const Density scaled = [&](double a, double b) { return scale * density(a, b); };
  double integral = 0;
  for (size_t i = 0; i < nu; ++i)
    for (size_t j = 0; j < nv; ++j) {
      const double a0 = static_cast<double>(i) / o.bins_u, a1 = a0 + 1.0 / o.bins_u;
      const double b0 = static_cast<double>(j) / o.bins_v, b1 = b0 + 1.0 / o.bins_v;
      const double coarse = gauss(scaled, a0, a1, b0, b1);
      const double hits = observed[i * nv + j];
      double mass = integrate(scaled, a0, a1, b0, b1, coarse, o.max_depth, o.tolerance);
      if (hits > kMinExpected && mass * o.samples < hits / 2)
        mass = integrate(scaled, a0, a1, b0, b1, coarse, o.max_depth, o.tolerance, kLookCloser);
      expected[i * nv + j] = mass * o.samples;
      integral += mass;
    }
  expected.back() = std::max(0.0, 1 - integral) * o.samples;

  Chi2 result = chi2_counts(observed, expected);
  result.integral = integral;
  char line[128];
  std::snprintf(line, sizeof line, "density integrates to %.6f; absorbed %.0f, expected %.1f\n",
                integral, observed.back(), expected.back());
  result.table = line + result.table;
  if (!(integral < 1 + 1e-3)) result.p_value = 0;
  return result;
}

std::string worst_cells(std::span<const double> observed, std::span<const double> expected) {
  std::vector<size_t> order(observed.size());
  std::iota(order.begin(), order.end(), size_t{0});
  const auto term = [&](size_t i) {
    return std::pow(observed[i] - expected[i], 2) / std::max(expected[i], 1.0);
  };
  const size_t shown = std::min<size_t>(12, order.size());
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(shown), order.end(),
                    [&](size_t a, size_t b) { return term(a) > term(b); });
  std::string text = "  cell   observed   expected\n";
  for (size_t i = 0; i < shown; ++i) {
    char line[96];
    std::snprintf(line, sizeof line, "%6zu %10.0f %10.2f\n", order[i], observed[order[i]],
                  expected[order[i]]);
    text += line;
  }
  return text;
}

}  // namespace

Chi2 chi2_counts(std::span<const double> observed, std::span<const double> expected) {
  Chi2 result;
  std::vector<size_t> order(expected.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::sort(order.begin(), order.end(),
            [&](size_t a, size_t b) { return expected[a] < expected[b]; });
  int groups = 0;
  double pooled_observed = 0, pooled_expected = 0;
  for (size_t k = 0; k < order.size(); ++k) {
    pooled_observed += observed[order[k]];
    pooled_expected += expected[order[k]];
    if (pooled_expected < kMinExpected && k + 1 < order.size()) continue;
    if (pooled_expected > 0) {
      result.statistic += std::pow(pooled_observed - pooled_expected, 2) / pooled_expected;
      ++groups;
    }
    pooled_observed = pooled_expected = 0;
  }
  result.dof = std::max(1, groups - 1);
  result.p_value = chi2_tail(result.statistic, result.dof);
  double impossible = 0;
  for (size_t i = 0; i < expected.size(); ++i)
    if (expected[i] < 1e-9) impossible += observed[i];
  if (impossible > kRounding) result.p_value = 0;
  char line[128];
  std::snprintf(line, sizeof line, "chi2 %.2f, %d degrees of freedom, p %.3g\n", result.statistic,
                result.dof, result.p_value);
  result.table = line + worst_cells(observed, expected);
  return result;
}

Chi2 chi2_sphere(const std::function<std::optional<Vec3>(Random&)>& sample,
                 const std::function<double(Vec3)>& pdf_w, const Chi2Options& options) {
  constexpr double kPiD = std::numbers::pi;
  return run(
      [&](Random& random) -> std::optional<Vec2> {
        const std::optional<Vec3> w = sample(random);
        if (!w) return std::nullopt;
        const double x = w->x, y = w->y, turn = std::atan2(y, x) / (2 * kPiD);
        return Vec2{static_cast<float>(std::atan2(std::hypot(x, y), w->z) / kPiD),
                    static_cast<float>(turn < 0 ? turn + 1 : turn)};
      },
      [&](double a, double b) {
        const double theta = kPiD * a, phi = 2 * kPiD * b, r = std::sin(theta);
        const Vec3 w{static_cast<float>(r * std::cos(phi)), static_cast<float>(r * std::sin(phi)),
                     static_cast<float>(std::cos(theta))};
        return r * pdf_w(w);
      },
      2 * kPiD * kPiD, options);
}

Chi2 chi2_square(const std::function<std::optional<Vec2>(Random&)>& sample,
                 const std::function<double(Vec2)>& pdf, const Chi2Options& options) {
  return run(
      sample,
      [&](double a, double b) {
        return pdf({static_cast<float>(a), static_cast<float>(b)});
      },
      1, options);
}

}  // namespace qray::test
