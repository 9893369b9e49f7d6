#include "core/laboratory/chart/statistics.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace qray {
namespace {

// P(|T| <= sqrt(freedom) tan(theta)), Abramowitz and Stegun 26.7.3 and 26.7.4.
double student_inside(double theta, int freedom) {
  const double cosine = std::cos(theta), sine = std::sin(theta);
  double term = freedom % 2 == 1 ? cosine : 1, sum = freedom == 1 ? 0 : term;
  for (int k = freedom % 2 == 1 ? 3 : 2; k < freedom; k += 2)
    sum += term *= cosine * cosine * (k - 1) / k;
  return freedom % 2 == 1 ? 2 / std::numbers::pi * (theta + sine * sum) : sine * sum;
}

}  // namespace

double mean(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double standard_error(std::span<const double> values) {
  const double middle = mean(values), n = static_cast<double>(values.size());
  double squares = 0;
  for (double v : values) squares += (v - middle) * (v - middle);
  return std::sqrt(squares / (n * (n - 1)));
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : (values[half - 1] + values[half]) / 2;
}

double student_quantile(double p, int freedom) {
  constexpr int kAsGoodAsNormal = 10'000;
  freedom = std::min(freedom, kAsGoodAsNormal);
  double low = 0, high = std::numbers::pi / 2;
  for (int step = 0; step < 60; ++step) {
    const double middle = (low + high) / 2;
    (student_inside(middle, freedom) < 2 * p - 1 ? low : high) = middle;
  }
  return std::sqrt(freedom) * std::tan((low + high) / 2);
}

Interval ratio_interval(std::span<const double> logs) {
  const double middle = mean(logs);
  const double half =
      standard_error(logs) * student_quantile(0.975, static_cast<int>(logs.size()) - 1);
  return {std::exp(middle), std::exp(middle - half), std::exp(middle + half)};
}

double bias_score(std::span<const double> values, double other_error) {
  const double difference = mean(values) - 1;
  if (difference == 0) return 0;
  return difference / std::hypot(standard_error(values), other_error);
}

double log_slope(std::span<const std::pair<double, double>> points) {
  const double n = static_cast<double>(points.size());
  double mean_x = 0, mean_y = 0;
  for (const auto& [x, y] : points) {
    mean_x += std::log(x) / n;
    mean_y += std::log(y) / n;
  }
  double xx = 0, xy = 0;
  for (const auto& [x, y] : points) {
    xx += (std::log(x) - mean_x) * (std::log(x) - mean_x);
    xy += (std::log(x) - mean_x) * (std::log(y) - mean_y);
  }
  return xy / xx;
}

std::optional<double> last_crossing(std::span<const std::pair<double, double>> points,
                                    double level) {
  if (points.empty() || points.back().second > level) return std::nullopt;
  size_t i = points.size() - 1;
  while (i > 0 && points[i - 1].second <= level) --i;
  if (i == 0) return points[0].first;
  const auto [x0, y0] = points[i - 1];
  const auto [x1, y1] = points[i];
  const double t = std::log(level / y0) / std::log(y1 / y0);
  return x0 * std::pow(x1 / x0, t);
}

}  // namespace qray
