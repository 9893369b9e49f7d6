#include "core/laboratory/chart/chart_run.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/image/metrics.h"
#include "tests/support/test_scenes.h"

namespace qray {
namespace {

TEST(ChartRuns, EachSeedBeginsWithTheNextMethodAndWarmFollowsCold) {
  ChartPlan plan;
  plan.scenes = {"room", "hall"};
  plan.methods = {"none", "huang"};
  plan.seeds = {7, 8};
  plan.warm = true;
  const std::vector<ChartRun> runs = chart_runs(plan);
  const std::vector<ChartRun> room = {{"room", "none", false, 7}, {"room", "huang", false, 7},
                                      {"room", "huang", true, 7}, {"room", "huang", false, 8},
                                      {"room", "huang", true, 8}, {"room", "none", false, 8}};
  ASSERT_EQ(runs.size(), 2 * room.size());
  EXPECT_TRUE(std::equal(room.begin(), room.end(), runs.begin()));
  EXPECT_EQ(runs[room.size()].scene, "hall");
  plan.warm = false;
  EXPECT_EQ(chart_runs(plan).size(), 8u);
}

TEST(ChartTimes, GrowBySqrt2UpToTheBudget) {
  const std::vector<double> times = chart_times(64);
  EXPECT_DOUBLE_EQ(times.front(), 0.25);
  EXPECT_NEAR(times.back() * std::sqrt(2), 64, 1e-9);
  for (size_t i = 1; i < times.size(); ++i)
    EXPECT_NEAR(times[i] / times[i - 1], std::sqrt(2), 1e-9);
}

TEST(TurnedCamera, TurnsAboutItself) {
  Camera camera;
  camera.position = {1, 2, 3};
  camera.target = {1, 1.5f, 1};  // two ahead, a little down
  const Camera left = turned(camera, 90);
  EXPECT_EQ(left.position, camera.position);
  EXPECT_NEAR(left.target.x, -1, 1e-5);
  EXPECT_NEAR(left.target.y, 1.5, 1e-5);
  EXPECT_NEAR(left.target.z, 3, 1e-5);
  EXPECT_NEAR(length(turned(camera, 360).target - camera.target), 0, 1e-5);
}

// A clock that goes on only by what tiles and observers are said to take.
class ManualClock final : public Clock {
 public:
  double seconds() const override { return now; }
  double now = 1000;
};
class SlowObserver final : public RenderObserver {
 public:
  explicit SlowObserver(ManualClock& clock) : clock_(clock) {}
  void on_tile(const RenderProgress&) override { clock_.now += 1; }  // rendering
  void on_pass(const RenderProgress&, const RenderStats&, const Guide*) override {
    clock_.now += 500;
  }

 private:
  ManualClock& clock_;
};

class MeasureRun : public ::testing::Test {
 protected:
  Result<ChartRunResult> measure(const ChartRun& run) {
    ManualClock clock;
    SlowObserver observer(clock);
    return measure_run(*scene_, plan_, run, reference_, pool_, observer, stop_.get_token(), clock);
  }
  MeasureRun() {
    plan_.width = plan_.height = 16;  // one tile: a second each pass
    plan_.seconds = 8;
    std::fill(reference_.data().begin(), reference_.data().end(), 0.5f);
  }
  std::shared_ptr<const PreparedScene> scene_ = test::prepare(test::room());
  ChartPlan plan_;
  Image reference_{16, 16, 3};
  TaskPool pool_{1};
  std::stop_source stop_;
};

TEST_F(MeasureRun, CountsRenderingAloneAndLooksAtEachTime) {
  const ChartRunResult result = measure({"room", "none:nee=off", false, 5}).value();
  const std::vector<double> times = chart_times(8);
  const std::vector<ChartRow>& rows = result.rows;
  ASSERT_GT(rows.size(), 3u);
  EXPECT_LE(rows.back().seconds, 9);
  EXPECT_GT(rows.back().seconds, 4);
  for (size_t i = 0; i < rows.size(); ++i) {
    const ChartRow& row = rows[i];
    EXPECT_EQ(row.scene, "room");
    EXPECT_EQ(row.method, "none:nee=off");
    EXPECT_EQ(row.seed, 5u);
    EXPECT_EQ(row.last, i + 1 == rows.size());
    EXPECT_EQ(row.seconds, std::round(row.seconds)) << "whole passes of a second";
    if (row.last) break;
    // The first whole second at or after a time, and not after the next.
    const size_t point = static_cast<size_t>(row.point);
    EXPECT_GE(row.seconds, times[point]);
    if (point + 1 < times.size()) {
      EXPECT_LT(row.seconds, times[point + 1]);
    }
    EXPECT_LT(row.samples_per_pixel, rows[i + 1].samples_per_pixel);
    EXPECT_LT(row.rays, rows[i + 1].rays);
    EXPECT_LT(row.point, rows[i + 1].point);
  }
  EXPECT_EQ(rows.front().samples_per_pixel, 1u);
  EXPECT_EQ(rows.back().point, static_cast<int>(times.size()));

  const ImageDifference end = image_difference(result.picture, reference_).value();
  EXPECT_EQ(rows.back().relmse, end.relmse);
  EXPECT_EQ(rows.back().relmse_trimmed, end.relmse_trimmed);
  EXPECT_EQ(rows.back().flip, end.flip);
  EXPECT_EQ(rows.back().mean_ratio, end.mean_ratio);
}

TEST_F(MeasureRun, AWarmRunStartsFromATable) {
  const ChartRow cold = measure({"room", "huang", false, 5}).value().rows.front();
  const ChartRow warm = measure({"room", "huang", true, 5}).value().rows.front();
  EXPECT_EQ(warm.seconds, cold.seconds);  // the other job's time is not counted
  EXPECT_TRUE(warm.warm);
  EXPECT_GT(warm.states, cold.states);
  EXPECT_NE(warm.relmse, cold.relmse);
  plan_.warm_turn_deg = 90;
  EXPECT_NE(measure({"room", "huang", true, 5}).value().rows.front().relmse, warm.relmse);
}

TEST_F(MeasureRun, ErrorsEndIt) {
  EXPECT_EQ(measure({"room", "huang:grid=x", false, 5}).error().code, ErrorCode::kInvalid);
  plan_.width = 17;  // the reference's is 16
  EXPECT_EQ(measure({"room", "none", false, 5}).error().where, "picture");
  stop_.request_stop();
  EXPECT_EQ(measure({"room", "huang", true, 5}).error().code, ErrorCode::kCanceled);
}

}  // namespace
}  // namespace qray
