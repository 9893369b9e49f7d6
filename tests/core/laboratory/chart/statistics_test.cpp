#include "core/laboratory/chart/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/laboratory/chart/summarize.h"

namespace qray {
namespace {

TEST(ChartStatistics, StudentQuantilesArePublishedOnes) {
  // Two-sided 95 %, 99 % and 99.9 %, any book's table.
  struct Case {
    int freedom;
    double t95, t99, t999;
  };
  const Case cases[] = {{1, 12.706, 63.657, 636.619}, {2, 4.303, 9.925, 31.599},
                        {3, 3.182, 5.841, 12.924},    {4, 2.776, 4.604, 8.610},
                        {9, 2.262, 3.250, 4.781},     {30, 2.042, 2.750, 3.646},
                        {120, 1.980, 2.617, 3.373},   {1 << 30, 1.960, 2.576, 3.291}};
  for (const Case& c : cases) {
    EXPECT_NEAR(student_quantile(0.975, c.freedom), c.t95, 6e-4 + 1e-5 * c.t95) << c.freedom;
    EXPECT_NEAR(student_quantile(0.995, c.freedom), c.t99, 6e-4 + 1e-5 * c.t99) << c.freedom;
    EXPECT_NEAR(student_quantile(0.9995, c.freedom), c.t999, 6e-4 + 1e-5 * c.t999) << c.freedom;
  }
  EXPECT_NEAR(student_quantile(0.5, 7), 0, 1e-9);
}

TEST(ChartStatistics, MomentsByHand) {
  const std::vector<double> values{1, 2, 6};
  EXPECT_DOUBLE_EQ(mean(values), 3);
  EXPECT_DOUBLE_EQ(standard_error(values), std::sqrt(7.0 / 3));  // s^2 = 14/2
  EXPECT_DOUBLE_EQ(median({6, 1, 2}), 2);
  EXPECT_DOUBLE_EQ(median({6, 1, 2, 4}), 3);
}

TEST(ChartStatistics, RatioIntervalByHand) {
  // Logs 0, 1, 2: mean 1, s = 1, t(2) = 4.3027.
  const double half = 4.30265 / std::sqrt(3.0);
  const Interval i = ratio_interval(std::vector<double>{0, 1, 2});
  EXPECT_NEAR(i.value, std::exp(1), 1e-9);
  EXPECT_NEAR(i.low, std::exp(1 - half), 1e-4);
  EXPECT_NEAR(i.high, std::exp(1 + half), 1e-3);
}

TEST(ChartStatistics, RatioIntervalHoldsTheTruthNinetyFiveTimesInAHundred) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(std::log(3), 0.4);
  int held = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    std::vector<double> logs(5);
    for (double& v : logs) v = noise(random);
    const Interval i = ratio_interval(logs);
    held += i.low <= 3 && 3 <= i.high;
  }
  EXPECT_NEAR(held / 4000.0, 0.95, 0.014);  // 4 standard errors
}

TEST(ChartStatistics, BiasScoreByHand) {
  // Mean 1.02, s^2 = 2.5e-4 / 3.
  const std::vector<double> runs{1.01, 1.015, 1.025, 1.03};
  const double own = std::sqrt(2.5e-4 / 3 / 4);
  EXPECT_NEAR(bias_score(runs, 0), 0.02 / own, 1e-9);
  EXPECT_NEAR(bias_score(runs, 0.012), 0.02 / std::hypot(own, 0.012), 1e-9);
  EXPECT_EQ(bias_score(std::vector<double>{1, 1, 1}, 0), 0);
  EXPECT_EQ(bias_score(std::vector<double>{1.1, 1.1}, 0), HUGE_VAL);
}

// Of charts with 6 series, 5 seeds each, all as bright as `truth`: the share with an alarm. Their
// common reference has an error of its own.
double share_alarmed(double truth, double own_error, double reference_error) {
  std::mt19937 random(2);
  std::normal_distribution<double> unit;
  constexpr int kCharts = 4000, kSeries = 6, kSeeds = 5;
  const double limit = student_quantile(1 - kBiasAlarm / 2 / kSeries, kSeeds - 1);
  int alarms = 0;
  for (int chart = 0; chart < kCharts; ++chart) {
    const double reference = 1 + reference_error * unit(random);
    bool alarm = false;
    for (int series = 0; series < kSeries; ++series) {
      std::vector<double> runs(kSeeds);
      for (double& v : runs) v = (truth + own_error * unit(random)) / reference;
      alarm = alarm || std::abs(bias_score(runs, reference_error)) > limit;
    }
    alarms += alarm;
  }
  return alarms / static_cast<double>(kCharts);
}

TEST(ChartStatistics, BiasAlarmsAreAsRareAsPromisedAndSeeARealBias) {
  // 0.0016: a standard error of 4000 charts.
  EXPECT_NEAR(share_alarmed(1, 0.02, 0), kBiasAlarm, 4 * 0.0016);
  EXPECT_LT(share_alarmed(1, 0.02, 0.004), kBiasAlarm + 4 * 0.0016);
  EXPECT_LT(share_alarmed(1, 0.004, 0.01), kBiasAlarm + 4 * 0.0016);
  EXPECT_GT(share_alarmed(1.15, 0.02, 0.004), 0.99);
}

TEST(ChartStatistics, SlopeOfAPowerLaw) {
  std::vector<std::pair<double, double>> points;
  for (double x : {1.0, 2.0, 5.0, 20.0}) points.emplace_back(x, 7 * std::pow(x, -0.8));
  EXPECT_NEAR(log_slope(points), -0.8, 1e-12);
}

TEST(ChartStatistics, LastCrossing) {
  using Points = std::vector<std::pair<double, double>>;
  const Points falling{{1, 16}, {4, 4}, {16, 1}};  // 16 / x
  EXPECT_NEAR(*last_crossing(falling, 8), 2, 1e-9);
  EXPECT_NEAR(*last_crossing(falling, 1), 16, 1e-9);
  EXPECT_FALSE(last_crossing(falling, 0.99));
  EXPECT_EQ(last_crossing(falling, 20), 1);                // from its first point on
  const Points lucky{{1, 16}, {2, 0.5}, {4, 4}, {16, 1}};  // a dip is not yet there to stay
  EXPECT_NEAR(*last_crossing(lucky, 2), 8, 1e-9);
  EXPECT_FALSE(last_crossing(Points{}, 1));
}

}  // namespace
}  // namespace qray
