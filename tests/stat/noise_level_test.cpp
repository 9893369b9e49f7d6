// The error that a job tells of its picture, and by which it ends (`noise`), against the distance
// of that picture from the mean of others of the same scene.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/render.h"

namespace qray {
namespace {

// As NoiseEstimate::level(): relative, without the greatest 0.1 % of the pixels.
double relative_error(const Image& picture, const Image& truth) {
  std::vector<double> squares;
  for (int y = 0; y < truth.height(); ++y)
    for (int x = 0; x < truth.width(); ++x) {
      const double expected = static_cast<double>(luminance(truth.rgb(x, y)));
      squares.push_back(sqr(static_cast<double>(luminance(picture.rgb(x, y))) - expected) /
                        (sqr(expected) + 0.01));
    }
  std::sort(squares.begin(), squares.end());
  squares.resize(squares.size() - squares.size() / 1000);
  double sum = 0;
  for (double s : squares) sum += s;
  return std::sqrt(sum / static_cast<double>(squares.size()));
}

// Sobol points make the error less than independent samples would, by 2.2 (its square) in these
// rooms: a job that did not know would render that much longer than it was asked to.
TEST(NoiseLevel, IsTheErrorOfThePicture) {
  for (const char* name : {"cornell-box", "thesis-room"}) {
    const auto scene = test::included_scene(name);
    constexpr int kSamples = 64, kTruthSamples = 1024;
    RenderSettings settings = test::small_settings("none", 32, kSamples);
    const Image truth =
        test::render(*scene, test::small_settings("none", 32, kTruthSamples, /*seed=*/99)).image;
    settings.noise = 1e-6;  // is never reached
    std::vector<double> ratios;
    for (settings.seed = 1; settings.seed <= 5; ++settings.seed) {
      const test::Rendered job = test::render(*scene, settings);
      EXPECT_EQ(job.job.stats.samples_per_pixel, static_cast<uint64_t>(kSamples));
      ratios.push_back(job.job.stats.noise / relative_error(job.image, truth));
    }
    const double ratio = test::median(ratios);
    EXPECT_GT(ratio, 1) << name;
    EXPECT_LT(ratio, 1.4) << name;
    RecordProperty(std::string("told_over_true_") + name, std::to_string(ratio));
  }
}

}  // namespace
}  // namespace qray
