// Pearson's chi-square test of a sampler against its density, on the sphere and on the unit square.
// Cells of low expectation are pooled; the density is integrated over each cell by adaptive
// Gauss-Legendre quadrature, so it may be peaked or piecewise constant. Any thread.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>

#include "core/math/vec.h"
#include "tests/support/random.h"

namespace qray::test {

struct Chi2 {
  double p_value = 0;  // compare with significance(number of tests); 0 when the sampler hit
                       // where the density is zero, or the density integrates to over 1
  double statistic = 0;
  int dof = 0;
  double integral = 0;  // of the density over the whole domain
  std::string table;    // the cells that contribute most; for a failed expectation's message
};

struct Chi2Options {
  int samples = 200'000;
  uint64_t seed = 1;
  int bins_u = 32;          // sphere: in theta, from +z; square: along x
  int bins_v = 64;          // sphere: in phi; square: along y
  int max_depth = 9;        // halvings of a cell's sides by the quadrature
  double tolerance = 1e-7;  // of a cell's integral, absolute
};

// nullopt counts as absorbed: expected to happen as often as the density lacks to 1.
Chi2 chi2_sphere(const std::function<std::optional<Vec3>(Random&)>& sample,
                 const std::function<double(Vec3)>& pdf_w, const Chi2Options& options = {});
Chi2 chi2_square(const std::function<std::optional<Vec2>(Random&)>& sample,
                 const std::function<double(Vec2)>& pdf, const Chi2Options& options = {});

// Counts against expectations (same order; the sums should agree but for chance).
Chi2 chi2_counts(std::span<const double> observed, std::span<const double> expected);

}  // namespace qray::test
