// A table from an earlier job makes the next job's picture better at equal samples.
#include <gtest/gtest.h>

#include "tests/support/render.h"

namespace qray {
namespace {

constexpr int kWarmSide = 64;  // pixels
constexpr uint64_t kWarmSeeds = 9;

test::Rendered run(const PreparedScene& scene, const std::string& method, bool nee, int samples,
                   uint64_t seed, std::optional<TableFile> table) {
  RenderSettings settings = test::small_settings(method, kWarmSide, samples, seed);
  settings.nee = nee;
  settings.max_depth = 16;
  return test::render(scene, settings, std::move(table));
}

TEST(Warm, ASecondJobStartsAheadOfACold) {
  const auto scene = test::included_scene("cornell-box");
  const Image reference = run(*scene, "none", true, 256, 1000, {}).image;
  std::vector<double> cold_errors, warm_errors;
  for (uint64_t seed = 1; seed <= kWarmSeeds; ++seed) {
    // The thesis' setting: the guide alone finds the light. The warm job has other samples.
    const test::Rendered cold = run(*scene, "huang", false, 64, seed, {});
    const test::Rendered warm = run(*scene, "huang", false, 64, seed + 100, cold.job.table);
    cold_errors.push_back(relmse(cold.image, reference));
    warm_errors.push_back(relmse(warm.image, reference));
  }
  std::printf("relMSE at 64 samples a pixel, median of %d seeds: cold %.4f, warm %.4f\n",
              static_cast<int>(kWarmSeeds), test::median(cold_errors), test::median(warm_errors));
  EXPECT_LT(test::median(warm_errors), 0.9 * test::median(cold_errors));
}

}  // namespace
}  // namespace qray
