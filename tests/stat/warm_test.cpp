// A table from an earlier job makes the next job's picture better at equal samples.
#include <gtest/gtest.h>

#include <algorithm>

#include "core/image/metrics.h"
#include "core/job/run_job.h"

namespace qray {
namespace {

constexpr int kSide = 64;  // pixels
constexpr uint64_t kSeeds = 9;

struct Outcome {
  Image image;
  std::optional<TableFile> table;
};

Outcome run(const PreparedScene& scene, const std::string& method, bool nee, int samples,
            uint64_t seed, std::optional<TableFile> table) {
  static TaskPool pool(2);
  RenderSettings settings;
  settings.method = method;
  settings.nee = nee;
  settings.width = settings.height = kSide;
  settings.samples = samples;
  settings.seed = seed;
  Film film(kSide, kSide);
  RenderObserver observer;
  auto job = run_job(scene, settings, std::move(table), film, pool, observer, {}, SteadyClock());
  EXPECT_TRUE(job.ok()) << job.error().text();
  return {film.develop(), std::move(job).value().table};
}

double error_of(const Outcome& outcome, const Image& reference) {
  return image_difference(outcome.image, reference).value().relmse;
}

double median(std::vector<double> v) {
  std::nth_element(v.begin(), v.begin() + static_cast<long>(v.size() / 2), v.end());
  return v[v.size() / 2];
}

TEST(Warm, ASecondJobStartsAheadOfACold) {
  auto scene = load_and_prepare_scene(
      std::filesystem::path(QRAY_SOURCE_DIR) / "scenes/cornell-box/scene.json", 2);
  ASSERT_TRUE(scene.ok()) << scene.error().text();
  const Image reference = run(*scene.value(), "none", true, 1024, 1000, {}).image;
  std::vector<double> cold_errors, warm_errors;
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    // The thesis' setting: the guide alone finds the light. The warm job has other samples.
    const Outcome cold = run(*scene.value(), "huang", false, 64, seed, {});
    const Outcome warm = run(*scene.value(), "huang", false, 64, seed + 100, cold.table);
    cold_errors.push_back(error_of(cold, reference));
    warm_errors.push_back(error_of(warm, reference));
  }
  std::printf("relMSE at 64 samples a pixel, median of %d seeds: cold %.4f, warm %.4f\n",
              static_cast<int>(kSeeds), median(cold_errors), median(warm_errors));
  EXPECT_LT(median(warm_errors), 0.9 * median(cold_errors));
}

}  // namespace
}  // namespace qray
