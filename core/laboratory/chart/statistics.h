// The few statistics that a chart's conclusions rest on. Pure functions; any thread.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "core/laboratory/chart/results.h"

namespace qray {

double mean(std::span<const double> values);  // of at least one
// Of the mean: s / sqrt(n), s with n - 1. At least two values.
double standard_error(std::span<const double> values);
double median(std::vector<double> values);  // the middle two's mean where their number is even

// t with P(T <= t) = p for Student's T with `freedom` >= 1 degrees; p in [0.5, 1).
double student_quantile(double p, int freedom);

// exp of the mean of `logs` with its 95 % interval. At least two values.
Interval ratio_interval(std::span<const double> logs);

// How far `values` (brightnesses of independent runs) are from 1, in standard errors; `other_error`
// is the known standard error of their common reference. To be judged as a Student's T of one
// degree less than runs: where the reference's error matters that errs on the side of no alarm,
// while Welch's degrees of freedom raised three times as many as promised.
double bias_score(std::span<const double> values, double other_error);

// Least squares of log y over log x. At least two points with different x; all positive.
double log_slope(std::span<const std::pair<double, double>> points);

// x at which the curve through points (x rising, all positive), straight between their logarithms,
// is at `level` and stays at or below it. The first x where it starts there; none where it ends
// above.
std::optional<double> last_crossing(std::span<const std::pair<double, double>> points,
                                    double level);

}  // namespace qray
